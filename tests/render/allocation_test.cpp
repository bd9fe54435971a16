#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <new>

#include <gtest/gtest.h>

#include "core/camera/lens_map.h"
#include "core/render/composed_renderer.h"
#include "core/stream/transcoder.h"
#include "core/truth/make_truth.h"
#include "core/truth/truth_json.h"
#include "core/world/camera_past.h"
#include "tests/render/support/backdrop_scenes.h"

// In steady state a picture costs no memory: what is needed was there the instant before. Counted are all blocks of C++
// in this program, those of the graphics driver (C) are not.
namespace {

std::atomic<std::uint64_t> blocks{0};

/// So many blocks there still are, then one that there is not.
constexpr std::int64_t endless = std::numeric_limits<std::int64_t>::max();
std::atomic<std::int64_t> blocks_left{endless};

/// Null when memory has run out.
void* counted(std::size_t bytes, std::size_t alignment) noexcept {
    blocks.fetch_add(1, std::memory_order_relaxed);
    if (blocks_left != endless && blocks_left-- == 0) return nullptr;
    return std::aligned_alloc(alignment, (bytes + alignment) / alignment * alignment);
}
void* counted_or_throw(std::size_t bytes, std::size_t alignment) {
    void* const memory = counted(bytes, alignment);
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}

}  // namespace

void* operator new(std::size_t bytes) {
    return counted_or_throw(bytes, alignof(std::max_align_t));
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
    return counted_or_throw(bytes, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
    return counted(bytes, alignof(std::max_align_t));
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
    std::free(memory);
}
void operator delete(void* memory, const std::nothrow_t&) noexcept {
    std::free(memory);
}

namespace camrig::render {
namespace {

constexpr int counted_instants = 16;
/// Blocks that so many instants of these views take once everything is warm. Movers go to and fro, some of them glass.
std::uint64_t blocks_of_instants(const std::vector<View>& views) {
    TestWorld world;
    world.lights = {light_of(world::LightType::directional, 0.8f, {}, glm::normalize(glm::dvec3(1.0, 0.4, -0.7)))};
    world::Material glass = colored({0.3f, 0.5f, 0.9f});
    glass.alpha_mode = world::AlphaMode::blend;
    glass.base_color.a = 0.4f;
    std::uint32_t id = 1;
    for (int i = -2; i <= 2; ++i) {
        const world::Material paint = colored({0.2f, 0.5f, 0.4f});
        world.objects.push_back(instance_of(model_of(box({0.4f, 0.4f, 0.7f}), paint), {5.0, 1.1 * i, -0.3}, id++));
        world.objects.push_back(instance_of(model_of(box({0.1f, 0.4f, 0.7f}), glass), {4.0, 1.1 * i, -0.3}, id++));
        world.movers.push_back(instance_of(model_of(box({0.1f, 0.1f, 0.2f}), paint), {3.5, 0.7 * i, 0.1}, id++));
        world.movers.push_back(instance_of(model_of(box({0.1f, 0.1f, 0.2f}), glass), {3.2, 0.7 * i, 0.1}, id++));
    }
    constexpr int warm_up = 16;  // eight frames of a camera are remembered
    std::vector<world::SnapshotRef> moments;
    for (int n = 0; n < warm_up + counted_instants; ++n) {
        auto moment = std::make_shared<world::Snapshot>(n == 0 ? *world.snapshot() : *moments.front());
        for (world::Instance& mover : moment->movers) mover.position.z = 0.1 * (n % 4);
        moments.push_back(moment);
    }
    std::uint64_t before = 0;
    for (int n = 0; n < warm_up + counted_instants; ++n) {
        if (n == warm_up) before = blocks;
        const auto finished = cpu_renderer().draw(moments[static_cast<std::size_t>(n)], 0, views);
        EXPECT_TRUE(finished.has_value() && finished->set.frames.size() == views.size());
    }
    return blocks - before;
}

TEST(SteadyState, APictureTakesNoMemory) {
    std::vector<View> views;
    for (std::uint32_t i = 0; i < 8; ++i) {
        views.push_back(TestCamera{.size = {320, 200}, .focal_px = 150.0}.view(i + 1));
        views.back().camera = CameraId{i + 1};
    }
    const std::vector<View> one(views.begin(), views.begin() + 1);
    // On a busy machine a thread may have its first picture late, and what it keeps with it: the least of three counts.
    std::uint64_t of_eight = blocks_of_instants(views), of_one = blocks_of_instants(one);
    for (int again = 0; again < 2; ++again) {
        of_eight = std::min(of_eight, blocks_of_instants(views));
        of_one = std::min(of_one, blocks_of_instants(one));
    }
    // The instant has its lists; a picture has the count of its readers (FrameRef). There is nothing else but the
    // pool's queue of frames that nobody uses: a std::deque, it takes a block for some 64 of the 128 pictures.
    EXPECT_LE(of_one, 8u * counted_instants);
    EXPECT_LE(of_eight, of_one + 7u * counted_instants + 4u);
    RecordProperty("blocks_of_instants_of_eight", static_cast<int>(of_eight));
    std::printf("blocks of %d instants: %d of one view, %d of eight\n", counted_instants, static_cast<int>(of_one),
                static_cast<int>(of_eight));
}

// Who polls the truth of a world that stands still asks for the same instant without end.
TEST(SteadyState, PicturesOfOneInstantWithoutEndTakeBoundedMemory) {
    constexpr int objects = 1024, pictures = 80;
    TestWorld world;
    for (std::uint32_t i = 0; i < objects; ++i) {
        const world::Material paint = colored(glm::vec3(0.5f));
        world.movers.push_back(instance_of(model_of(box(glm::vec3(0.01f)), paint),
                                           {5.0, 0.02 * (i % 32) - 0.3, 0.02 * (i / 32) - 0.2}, i + 1));
    }
    const world::SnapshotRef moment = world.snapshot();
    View view = TestCamera{.size = {16, 16}, .focal_px = 40.0}.view();
    std::ranges::fill(view.kinds, false);
    view.kinds[static_cast<int>(frame::FrameKind::instance)] = true;
    for (int n = 0; n < pictures; ++n) {
        ASSERT_TRUE(cpu_renderer().draw(moment, 0, {&view, 1}).has_value());
    }
    EXPECT_LE(cpu_renderer().counters().draw_data_bytes, std::int64_t{12} << 20) << "of all of them: 15 MiB";
}

// Every block of a picture in turn is the one that there is no memory for: the first pictures of cameras, those that
// make a layer, and those that use one.
TEST(Exhausted, MemoryIsAnErrorOfThePictureAndTheNextOneIsAsItWouldHaveBeen) {
    TestWorld world;
    world.lights = {light_of(world::LightType::directional, 0.8f, {}, glm::normalize(glm::dvec3(1.0, 0.4, -0.7)))};
    world.objects = {instance_of(model_of(box(glm::vec3(0.5f)), colored({0.2f, 0.5f, 0.4f})), {5, 0, 0}, 1)};
    world.movers = {instance_of(model_of(box(glm::vec3(0.2f)), colored({0.9f, 0.5f, 0.4f})), {4, 0.5, 0}, 2)};
    const world::SnapshotRef moment = world.snapshot();
    const camera::Lens barrel =
        camera::make_lens(camera::LensModel::plumb_bob, std::vector{-0.25, 0.05, 0.001, -0.001, 0.0}).value();
    std::vector<View> views{
        TestCamera{.size = {64, 48}}.view(1), TestCamera{.size = {60, 40}, .focal_px = 40.0, .lens = barrel}.view(2),
        TestCamera{.size = {48, 32}, .antialias = world::Antialias::coverage, .quality = world::Quality::beautiful}
            .view(3)};
    views[0].kinds[static_cast<int>(frame::FrameKind::instance)] = true;
    ComposedRenderer renderer(
        {.pool = std::make_shared<frame::FramePool>(), .static_layer_bytes = 1 << 28, .threads = 2},
        [] { return error(ErrorKind::unsupported, "nothing here is drawn elsewhere"); });
    const auto bytes_now = [&] {
        auto finished = renderer.draw(std::make_shared<world::Snapshot>(*moment), 0, views);
        std::vector<std::byte> bytes;
        for (const frame::FrameRef& frame : finished.value().set.frames)
            bytes.insert(bytes.end(), frame->bytes().begin(), frame->bytes().end());
        return bytes;
    };
    const std::vector<std::byte> expected = bytes_now();
    for (int pictures = 0; pictures < 4; ++pictures) {
        bool has_run_out = true;
        for (std::int64_t left = 0; has_run_out; ++left) {
            for (const View& view : views) renderer.forget(view.camera);
            for (int n = 0; n < pictures; ++n) bytes_now();
            const auto instant = std::make_shared<world::Snapshot>(*moment);
            blocks_left = left;
            const auto finished = renderer.draw(instant, 0, views);
            has_run_out = blocks_left < 0;
            blocks_left = endless;
            ASSERT_TRUE(finished || finished.error().kind == ErrorKind::resource_exhausted);
            ASSERT_EQ(bytes_now(), expected) << "after " << pictures << " pictures and " << left << " blocks";
        }
    }
}

// A moment of the flow has the shapes of its backdrop, and a sensor's moments come after it.
TEST(Exhausted, MemoryForFlowBeforeABackdropLeavesNothingOfItInPicturesOfASensor) {
    constexpr TimeNs now_ns = 100 * ns_per_ms, frame_ns = 40 * ns_per_ms;
    auto scene = std::make_shared<world::Scene>();
    scene->models["box"].model = model_of(box(glm::vec3(0.5f)), colored(glm::vec3(0.5f)));
    world::ObjectSpec object;
    object.name = object.model = "box";
    object.position = {5, 0, 1};
    scene->objects.push_back(object);
    const auto world = world::World::create(scene, 1).value();
    world->advance_to(now_ns);
    const world::SnapshotRef moment = world->snapshot(now_ns);

    const TestCamera camera{.eye = {0, 0, 1.6}, .size = {64, 48}};
    world::ProxiesSpec proxies;
    proxies.ground.emplace().polygon_m = {{1, -8}, {12, -8}, {12, 8}, {1, 8}};
    View flowing = with_plate(camera.view(1), noise(camera.size), proxies);
    std::ranges::fill(flowing.kinds, false);
    flowing.kinds[static_cast<int>(frame::FrameKind::flow)] = true;
    flowing.frame_ns = frame_ns;
    const world::Camera standing(*flowing.spec);

    View sensing = camera.view(2);
    auto with_sensor = std::make_shared<world::CameraSpec>(*sensing.spec);
    with_sensor->pose = sensing.pose;
    with_sensor->sensor.emplace().exposure_s = 0.02;
    sensing.spec = with_sensor;
    world::CameraPatch move;
    move.optics = with_sensor->intrinsics;
    move.pose = camera::Pose{.position = {0, 0.5, 1.6}, .orientation = sensing.pose.orientation};
    const world::Camera moving = world::Camera(*with_sensor).changed(move, 0, now_ns).value();
    sensing.past = std::make_shared<const world::CameraPast>(world->past(0), moving);
    sensing.pose = moving.at(*moment).pose;

    ComposedRenderer renderer({.pool = std::make_shared<frame::FramePool>(), .threads = 2},
                              [] { return error(ErrorKind::unsupported, "nothing here is drawn elsewhere"); });
    const auto sensed = [&] {
        const auto finished = renderer.draw(std::make_shared<world::Snapshot>(*moment), 0, {&sensing, 1}).value();
        const auto bytes = finished.set.frames.at(0)->bytes();
        return std::vector<std::byte>(bytes.begin(), bytes.end());
    };
    const std::vector<std::byte> expected = sensed();
    bool has_run_out = true;
    for (std::int64_t left = 0; has_run_out; ++left) {
        flowing.future =
            std::make_shared<world::CameraFuture>(world->copy(), "camera1", standing, std::vector<world::CameraMove>{});
        const auto instant = std::make_shared<world::Snapshot>(*moment);
        blocks_left = left;
        const auto finished = renderer.draw(instant, 0, {&flowing, 1});
        has_run_out = blocks_left < 0;
        blocks_left = endless;
        ASSERT_TRUE(finished || finished.error().kind == ErrorKind::resource_exhausted);
        ASSERT_EQ(sensed(), expected) << "after " << left << " blocks";
        EXPECT_TRUE(has_run_out || finished->set.frames.size() == 1u);
    }
}

TEST(Exhausted, MemoryForTruthLeavesNothingHalfFoundOfStandingObjects) {
    TestWorld world;
    for (std::uint32_t id = 1; id <= 6; ++id)
        world.objects.push_back(
            instance_of(model_of(box(glm::vec3(0.3f)), colored(glm::vec3(0.5f))), {5.0, id - 3.5, 0.0}, id));
    const world::SnapshotRef moment = world.snapshot();
    View view = TestCamera{}.view();
    std::ranges::fill(view.kinds, false);
    view.kinds[static_cast<int>(frame::FrameKind::instance)] = true;
    view.kinds[static_cast<int>(frame::FrameKind::depth)] = true;
    const auto frames = draw_views(moment, {&view, 1});
    const auto of_kind = [&](frame::FrameKind kind) {
        return *std::ranges::find(frames, kind, [](const frame::FrameRef& frame) { return frame->info().kind; });
    };
    const truth::TruthView of{.name = view.name, .spec = view.spec, .pose = view.pose};
    const truth::TruthPictures pictures{.instance = of_kind(frame::FrameKind::instance),
                                        .depth = of_kind(frame::FrameKind::depth)};
    const auto silhouettes = truth::silhouettes_from(
        [&](std::span<const ObjectId>) -> Result<frame::FrameRef> { return pictures.instance; });
    const auto text_of = [&](truth::StandingObjects& standing) {
        return truth_to_json(make_truth(of, *moment, pictures, silhouettes, &standing).value()).dump();
    };
    truth::StandingObjects other;
    const std::string expected = text_of(other);
    bool has_run_out = true;
    for (std::int64_t left = 0; has_run_out; ++left) {
        truth::StandingObjects standing;
        blocks_left = left;
        try {
            static_cast<void>(make_truth(of, *moment, pictures, silhouettes, &standing));
        } catch (const std::bad_alloc&) {
        }
        has_run_out = blocks_left < 0;
        blocks_left = endless;
        ASSERT_EQ(text_of(standing), expected) << "after " << left << " blocks";
    }
}

constexpr int counted_frames = 16;
/// Blocks that bringing so many frames into this format takes once everything is warm. Of each frame other rows
/// changed.
std::uint64_t blocks_of_units(const stream::MediaFormat& format) {
    constexpr ImageSize size{320, 200};
    auto pool = std::make_shared<frame::FramePool>();
    auto transcoder = stream::Transcoder::create(format, pool, std::make_shared<stream::TranscodeTimers>()).value();
    constexpr int warm_up = 8;
    std::vector<frame::FrameRef> frames;
    for (int n = 0; n < warm_up + counted_frames; ++n) {
        frame::FrameInfo info;
        info.camera = std::make_shared<const std::string>("lobby");
        info.sequence = n;
        info.size = size;
        info.damage = frame::Damage::since(n - 1);
        info.damage.add(13 * (n % 4), 13 * (n % 4) + 40);
        std::vector<std::byte> bytes(bytes_of(frame::PixelFormat::rgba8, size));
        for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i >> 6);
        frames.push_back(std::make_shared<const frame::Frame>(std::move(info), std::move(bytes)));
    }
    std::uint64_t before = 0;
    for (int n = 0; n < warm_up + counted_frames; ++n) {
        if (n == warm_up) before = blocks;
        EXPECT_TRUE(transcoder->transcode(frames[static_cast<std::size_t>(n)]).has_value());
    }
    return blocks - before;
}

TEST(SteadyState, AUnitForReadersTakesNoMemoryButTheCountOfItsReaders) {
    EXPECT_LE(blocks_of_units({codec::Codec::jpeg, {}, 90, {}}), 1u * counted_frames);
    EXPECT_LE(blocks_of_units({codec::Codec::raw, frame::PixelFormat::yuyv, 0, {}}), 1u * counted_frames);
    EXPECT_LE(blocks_of_units({codec::Codec::raw, frame::PixelFormat::i420, 0, {160, 100}}), 2u * counted_frames)
        << "scaled first";
    EXPECT_EQ(blocks_of_units({codec::Codec::raw, frame::PixelFormat::rgba8, 0, {}}), 0u);
}

}  // namespace
}  // namespace camrig::render
