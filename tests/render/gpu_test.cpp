#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/render/support/test_rig.h"

// How a GPU's pictures come to host memory, and whether a GPU draws what the CPU rasteriser draws. Every test has the
// process's only renderer: two GL contexts on one thread would be in each other's way.
namespace camrig {
namespace {

TestWorld boxes() {
    TestWorld world;
    world.lights = {light_of(LightType::directional, 0.8f, {}, glm::normalize(glm::dvec3(1.0, 0.4, -0.7)))};
    std::uint32_t id = 1;
    for (int i = -2; i <= 2; ++i) {
        const Material paint = colored({0.2f + 0.15f * static_cast<float>(i), 0.5f, 0.4f});
        world.objects.push_back(instance_of(model_of(box({0.4f, 0.4f, 0.7f}), paint), {5.0, 1.1 * i, -0.3}, id++));
    }
    world.movers.push_back(instance_of(model_of(box({0.3f, 0.3f, 0.5f}), colored({0.9f, 0.2f, 0.1f})), {4, 0, 0}, id));
    return world;
}

/// Three instants of two cameras, all kinds of pictures, with as many instants in flight as may be.
std::vector<FrameRef> film(Renderer& renderer) {
    std::vector<View> views{TestCamera{.size = {160, 120}, .focal_px = 100.0}.view(1),
                            TestCamera{.eye = {0.0, 0.5, 0.3}, .size = {81, 61}, .focal_px = 60.0}.view(2)};
    for (View& view : views) std::fill(std::begin(view.kinds), std::end(view.kinds), true);
    const SnapshotRef first = boxes().snapshot();
    std::vector<FrameRef> frames;
    const auto collect = [&] {
        auto finished = renderer.collect();
        ASSERT_TRUE(finished && finished->failures.empty());
        for (FrameRef& frame : finished->set.frames) frames.push_back(std::move(frame));
    };
    for (int n = 0; n < 3; ++n) {
        auto snapshot = std::make_shared<Snapshot>(*first);
        snapshot->movers[0].position.y = -0.6 + 0.5 * n;
        if (renderer.in_flight() == Renderer::max_in_flight) collect();
        EXPECT_TRUE(renderer.submit(snapshot, 0, views).has_value());
    }
    while (renderer.in_flight() > 0) collect();
    return frames;
}

std::vector<FrameRef> film_on(const std::string& device, bool is_buffered = false) {
    auto renderer =
        create_renderer({.device = device, .pool = std::make_shared<FramePool>(), .buffered_readback = is_buffered});
    if (!renderer) {
        ADD_FAILURE() << renderer.error().message;
        return {};
    }
    return film(**renderer);
}

TEST(BufferedReadback, GivesTheBytesOfDirectReading) {
    const auto direct = film_on("llvmpipe"), buffered = film_on("llvmpipe", true);
    ASSERT_EQ(direct.size(), 3u * 2u * frame_kind_count);
    ASSERT_EQ(buffered.size(), direct.size());
    for (std::size_t i = 0; i < direct.size(); ++i)
        EXPECT_TRUE(std::ranges::equal(direct[i]->bytes(), buffered[i]->bytes())) << "picture " << i;
}

TEST(HardwareDevice, DrawsWhatTheCpuDraws) {
    {
        auto renderer = create_renderer({.device = "", .pool = std::make_shared<FramePool>()});
        ASSERT_TRUE(renderer.has_value()) << renderer.error().message;
        if ((*renderer)->description().starts_with("camrig's rasteriser"))
            GTEST_SKIP() << "no EGL device with hardware here";
    }
    const auto gpu = film_on(""), cpu = film_on("cpu");
    ASSERT_EQ(gpu.size(), cpu.size());
    for (std::size_t i = 0; i < gpu.size(); ++i) {
        if (gpu[i]->info().kind != FrameKind::color) continue;
        // Rasterisers may differ by a pixel at edges and a code inside: the mean holds both to almost nothing.
        double sum = 0.0;
        for (std::size_t at = 0; at < gpu[i]->bytes().size(); ++at)
            sum += std::abs(std::to_integer<int>(gpu[i]->bytes()[at]) - std::to_integer<int>(cpu[i]->bytes()[at]));
        EXPECT_LT(sum / static_cast<double>(gpu[i]->bytes().size()), 0.5) << "picture " << i;
    }
}

}  // namespace
}  // namespace camrig
