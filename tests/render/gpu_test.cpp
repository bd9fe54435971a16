#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/frame/convert.h"
#include "tests/render/support/test_rig.h"

// How a GPU's pictures come to host memory, and whether a GPU draws what the CPU rasteriser draws. Every test has the
// process's only renderer: two GL contexts on one thread would be in each other's way.
namespace camrig::render {
namespace {

TestWorld boxes() {
    TestWorld world;
    world.lights = {light_of(world::LightType::directional, 0.8f, {}, glm::normalize(glm::dvec3(1.0, 0.4, -0.7)))};
    std::uint32_t id = 1;
    for (int i = -2; i <= 2; ++i) {
        const world::Material paint = colored({0.2f + 0.15f * static_cast<float>(i), 0.5f, 0.4f});
        world.objects.push_back(instance_of(model_of(box({0.4f, 0.4f, 0.7f}), paint), {5.0, 1.1 * i, -0.3}, id++));
    }
    world.movers.push_back(instance_of(model_of(box({0.3f, 0.3f, 0.5f}), colored({0.9f, 0.2f, 0.1f})), {4, 0, 0}, id));
    return world;
}

/// Three instants of two cameras, all kinds of pictures.
std::vector<frame::FrameRef> film(Renderer& renderer) {
    std::vector<View> views{TestCamera{.size = {160, 120}, .focal_px = 100.0}.view(1),
                            TestCamera{.eye = {0.0, 0.5, 0.3}, .size = {81, 61}, .focal_px = 60.0}.view(2)};
    for (View& view : views) std::fill_n(view.kinds, frame::scene_kind_count, true);
    const world::SnapshotRef first = boxes().snapshot();
    std::vector<frame::FrameRef> frames;
    for (int n = 0; n < 3; ++n) {
        auto snapshot = std::make_shared<world::Snapshot>(*first);
        snapshot->movers[0].position.y = -0.6 + 0.5 * n;
        auto finished = renderer.draw(snapshot, 0, views).value();
        EXPECT_TRUE(finished.failures.empty());
        std::ranges::move(finished.set.frames, std::back_inserter(frames));
    }
    return frames;
}

std::vector<frame::FrameRef> film_on(const std::string& device, bool is_buffered = false) {
    auto renderer = create_renderer(
        {.device = device, .pool = std::make_shared<frame::FramePool>(), .buffered_readback = is_buffered});
    if (!renderer) {
        ADD_FAILURE() << renderer.error().message;
        return {};
    }
    return film(**renderer);
}

/// A picture of a camera with a sensor, all its kinds, beside one without.
std::vector<frame::FrameRef> taken_on(const std::string& device, const sensor::SensorSpec& spec,
                                      world::Antialias antialias = world::Antialias::none) {
    View with = TestCamera{.size = {80, 60}, .focal_px = 50.0, .antialias = antialias}.view(2);
    auto seen_by_sensor = std::make_shared<world::CameraSpec>(*with.spec);
    seen_by_sensor->sensor = spec;
    with.spec = seen_by_sensor;
    std::fill_n(with.kinds, frame::scene_kind_count, true);
    with.kinds[index_of(frame::FrameKind::sensor)] = true;
    const std::vector<View> views{TestCamera{.size = {160, 120}, .focal_px = 100.0}.view(1), with};
    const auto renderer = create_renderer({.device = device, .pool = std::make_shared<frame::FramePool>()}).value();
    auto finished = renderer->draw(boxes().snapshot(), 0, views).value();
    for (const auto& failure : finished.failures) {
        EXPECT_EQ(failure.camera, CameraId{2});
        EXPECT_NE(failure.error.message.find("rasteriser"), std::string::npos) << failure.error.message;
    }
    return finished.set.frames;
}

TEST(ADevice, LeavesCamerasWithASensorToOurRasteriser) {
    const sensor::SensorSpec spec = sensor::sensor_preset(sensor::SensorPreset::imx219);
    const auto on_cpu = taken_on("cpu", spec), on_device = taken_on("llvmpipe", spec);
    ASSERT_EQ(on_cpu.size(), 2u + frame::scene_kind_count);
    ASSERT_EQ(on_device.size(), on_cpu.size());
    // The first is of the other camera, which the device draws its own way.
    EXPECT_EQ(on_device[0]->info().camera_id, CameraId{1});
    for (std::size_t i = 1; i < on_cpu.size(); ++i) {
        EXPECT_EQ(on_device[i]->info().kind, on_cpu[i]->info().kind);
        EXPECT_TRUE(std::ranges::equal(on_device[i]->bytes(), on_cpu[i]->bytes())) << "picture " << i;
    }
    // What neither draws is refused with the reason, and costs the other camera nothing.
    const auto refused = taken_on("llvmpipe", spec, world::Antialias::msaa4);
    ASSERT_FALSE(refused.empty());
    EXPECT_EQ(refused[0]->info().camera_id, CameraId{1});
    EXPECT_LT(refused.size(), on_cpu.size());
}

TEST(BufferedReadback, GivesTheBytesOfDirectReading) {
    const auto direct = film_on("llvmpipe"), buffered = film_on("llvmpipe", true);
    ASSERT_EQ(direct.size(), 3u * 2u * frame::scene_kind_count);
    ASSERT_EQ(buffered.size(), direct.size());
    for (std::size_t i = 0; i < direct.size(); ++i)
        EXPECT_TRUE(std::ranges::equal(direct[i]->bytes(), buffered[i]->bytes())) << "picture " << i;
}

/// A wall of triangles in all colours, a corner a colour of its own.
TestWorld colours() {
    constexpr int columns = 12, rows = 9;
    std::uint32_t state = 1;
    const auto next = [&] {
        state = state * 1664525u + 1013904223u;
        return static_cast<float>(state >> 8) / static_cast<float>(1 << 24);
    };
    std::vector<glm::vec3> corners;
    for (int i = 0; i < columns * rows; ++i) {
        const glm::vec3 low(4.0f, 0.4f * static_cast<float>(i % columns) - 2.4f,
                            0.4f * static_cast<float>(i / columns) - 1.8f);
        const glm::vec3 y(0.0f, 0.4f, 0.0f), z(0.0f, 0.0f, 0.4f);
        for (const glm::vec3& corner : {low, low + z, low + y, low + y, low + z, low + y + z})
            corners.push_back(corner);
    }
    world::Primitive wall = triangles(corners);
    for (std::size_t i = 0; i < corners.size(); ++i) wall.colors.emplace_back(next(), next(), next(), 1.0f);
    world::Material paint = colored(glm::vec3(1.0f), true);
    paint.double_sided = true;
    TestWorld world;
    world.objects.push_back(instance_of(model_of(std::move(wall), paint)));
    return world;
}

std::vector<frame::FrameRef> drawn(Renderer& renderer, const world::SnapshotRef& world, const View& view) {
    auto finished = renderer.draw(world, 0, {&view, 1});
    EXPECT_TRUE(finished && finished->failures.empty());
    return finished ? finished->set.frames : std::vector<frame::FrameRef>{};
}

void expect_bytes_of_the_host(Renderer& renderer) {
    const world::SnapshotRef world = colours().snapshot();
    const camera::Lens lens{.model = camera::LensModel::plumb_bob, .coefficients = {-0.2, 0.05}};
    for (TestCamera camera :
         {TestCamera{.size = {160, 120}}, TestCamera{.size = {17, 33}}, TestCamera{.size = {641, 359}},
          TestCamera{.size = {1282, 18}}, TestCamera{.size = {81, 61}, .lens = lens},
          TestCamera{.size = {98, 75}, .antialias = world::Antialias::msaa4}}) {
        camera.focal_px = 0.8 * camera.size.height;
        View view = camera.view();
        view.color_formats = {};
        for (const frame::PixelFormat format : frame::color_formats) {
            ASSERT_TRUE(renderer.makes(format, view));
            view.color_formats.add(format);
        }
        const auto frames = drawn(renderer, world, view);
        ASSERT_EQ(frames.size(), frame::color_formats.size());
        ASSERT_EQ(frames[0]->info().format, frame::PixelFormat::rgba8);
        for (std::size_t i = 0; i < frames.size(); ++i) {
            const frame::FrameInfo& info = frames[i]->info();
            EXPECT_EQ(info.format, frame::color_formats[i]);
            std::vector<std::byte> expected(bytes_of(info.format, info.size));
            ASSERT_TRUE(convert(*frames[0], info.format, {}, expected).has_value());
            EXPECT_TRUE(std::ranges::equal(frames[i]->bytes(), expected))
                << to_string(info.format) << " " << info.size.to_string();
        }
    }
    EXPECT_EQ(renderer.counters().conversions, 6 * (frame::color_formats.size() - 1));
}

class ConvertedOnTheDevice : public testing::Test {
protected:
    void SetUp() override {
        auto made = create_renderer(
            {.device = "llvmpipe", .pool = std::make_shared<frame::FramePool>(), .conversion = Conversion::device});
        ASSERT_TRUE(made.has_value()) << made.error().message;
        renderer = std::move(*made);
    }

    std::unique_ptr<Renderer> renderer;
};

TEST_F(ConvertedOnTheDevice, EveryLayoutHasTheBytesOfTheHost) {
    expect_bytes_of_the_host(*renderer);
}

TEST_F(ConvertedOnTheDevice, InstantsKeepTheirPictures) {
    const world::SnapshotRef first = boxes().snapshot();
    View view = TestCamera{.size = {81, 61}, .focal_px = 60.0}.view();
    view.color_formats.add(frame::PixelFormat::i420);
    std::vector<frame::FrameRef> frames;
    for (int n = 0; n < 6; ++n) {
        auto snapshot = std::make_shared<world::Snapshot>(*first);
        snapshot->movers[0].position.y = -0.6 + 0.2 * n;
        std::ranges::move(drawn(*renderer, snapshot, view), std::back_inserter(frames));
    }
    ASSERT_EQ(frames.size(), 12u);
    for (std::size_t i = 0; i < frames.size(); i += 2) {
        std::vector<std::byte> expected(bytes_of(frame::PixelFormat::i420, {81, 61}));
        ASSERT_TRUE(convert(*frames[i], frame::PixelFormat::i420, {}, expected).has_value());
        EXPECT_TRUE(std::ranges::equal(frames[i + 1]->bytes(), expected)) << "instant " << i / 2;
        EXPECT_TRUE(i == 0 || !std::ranges::equal(frames[i]->bytes(), frames[i - 2]->bytes())) << "the mover moves";
    }
}

// Everything about the frame but its layout is that of the rgba8 picture, and other kinds are as ever.
TEST_F(ConvertedOnTheDevice, AFrameIsOfItsInstant) {
    View view = TestCamera{}.view(7);
    view.sequence = 12;
    view.color_formats = {frame::PixelFormat::i420};
    view.kinds[static_cast<int>(frame::FrameKind::depth)] = true;
    const auto frames = drawn(*renderer, colours().snapshot(), view);
    ASSERT_EQ(frames.size(), 2u);
    EXPECT_EQ(frames[0]->info().format, frame::PixelFormat::i420);
    EXPECT_EQ(frames[0]->info().kind, frame::FrameKind::color);
    EXPECT_EQ(frames[0]->info().sequence, 12);
    EXPECT_EQ(frames[1]->info().format, frame::PixelFormat::depth32f);
    EXPECT_FLOAT_EQ(*reinterpret_cast<const float*>(frames[1]->bytes().data()), 4.0f);
}

// They are made on the host, after drawing.
TEST_F(ConvertedOnTheDevice, PicturesWithImageControlsOrACodeStripStayRgba) {
    View view = TestCamera{}.view();
    auto spec = std::make_shared<world::CameraSpec>(*view.spec);
    spec->code_strip = true;
    view.spec = spec;
    EXPECT_FALSE(renderer->makes(frame::PixelFormat::i420, view));
    EXPECT_TRUE(renderer->makes(frame::PixelFormat::rgba8, view));
    spec = std::make_shared<world::CameraSpec>(*TestCamera{}.view().spec);
    spec->controls.brightness = 0.1;
    view.spec = spec;
    EXPECT_FALSE(renderer->makes(frame::PixelFormat::i420, view));
    EXPECT_FALSE(renderer->makes(frame::PixelFormat::depth32f, TestCamera{}.view()));
}

TEST(Conversion, OnTheDeviceNeedsOneThatDrawsByOpenGl) {
    for (const std::string device : {"cpu", "null"}) {
        const auto made = create_renderer(
            {.device = device, .pool = std::make_shared<frame::FramePool>(), .conversion = Conversion::device});
        ASSERT_FALSE(made.has_value());
        EXPECT_EQ(made.error().kind, ErrorKind::invalid_argument);
    }
    auto host = create_renderer(
        {.device = "llvmpipe", .pool = std::make_shared<frame::FramePool>(), .conversion = Conversion::host});
    ASSERT_TRUE(host.has_value());
    EXPECT_FALSE((*host)->makes(frame::PixelFormat::i420, TestCamera{}.view()));
}

/// The one that is taken by itself; null where it is no hardware.
std::unique_ptr<Renderer> hardware() {
    auto renderer = create_renderer({.device = "", .pool = std::make_shared<frame::FramePool>()});
    EXPECT_TRUE(renderer.has_value());
    if (!renderer || (*renderer)->description().starts_with("camrig's rasteriser")) return nullptr;
    return std::move(*renderer);
}

TEST(HardwareDevice, ConvertsColoursLikeTheHost) {
    const auto renderer = hardware();
    if (renderer == nullptr) GTEST_SKIP() << "no EGL device with hardware here";
    expect_bytes_of_the_host(*renderer);
}

TEST(HardwareDevice, DrawsWhatTheCpuDraws) {
    if (hardware() == nullptr) GTEST_SKIP() << "no EGL device with hardware here";
    const auto gpu = film_on(""), cpu = film_on("cpu");
    ASSERT_EQ(gpu.size(), cpu.size());
    for (std::size_t i = 0; i < gpu.size(); ++i) {
        if (gpu[i]->info().kind != frame::FrameKind::color) continue;
        // Rasterisers may differ by a pixel at edges and a code inside: the mean holds both to almost nothing.
        double sum = 0.0;
        for (std::size_t at = 0; at < gpu[i]->bytes().size(); ++at)
            sum += std::abs(std::to_integer<int>(gpu[i]->bytes()[at]) - std::to_integer<int>(cpu[i]->bytes()[at]));
        EXPECT_LT(sum / static_cast<double>(gpu[i]->bytes().size()), 0.5) << "picture " << i;
    }
}

}  // namespace
}  // namespace camrig::render
