// What happens to a picture after it was drawn: colour conversion, JPEG, PNG, code strip. Run from the repository.
#include <benchmark/benchmark.h>

#include "core/codec/encoder.h"
#include "core/frame/code_strip.h"
#include "core/frame/convert.h"
#include "core/render/renderer_factory.h"
#include "core/world/world.h"

namespace camrig::bench {
namespace {

/// A picture of the hall: codecs take as long as what they are given is rich. Aborts where there is no CPU rasteriser.
frame::FrameRef picture(ImageSize size) {
    static std::map<std::pair<int, int>, frame::FrameRef> made;
    frame::FrameRef& frame = made[{size.width, size.height}];
    if (frame) return frame;
    const auto scene = world::load_scene("scenes/hall.json");
    CHECK(scene.has_value());
    auto world = world::World::create(*scene, 1);
    auto renderer = render::create_renderer({.device = "cpu", .pool = std::make_shared<frame::FramePool>()});
    CHECK(world.has_value() && renderer.has_value());
    const world::Place& place = (*scene)->places.at("lobby");
    auto spec = std::make_shared<world::CameraSpec>();
    spec->name = "lobby";
    spec->size = size;
    spec->intrinsics = *camera::intrinsics_from_vfov(size, place.vfov_rad);
    render::View view;
    view.name = std::make_shared<const std::string>("lobby");
    view.spec = std::move(spec);
    view.pose = place.pose;
    auto finished = (*renderer)->draw((*world)->snapshot(0), 0, {&view, 1});
    CHECK(finished && finished->set.frames.size() == 1);
    return frame = finished->set.frames.front();
}

ImageSize size_of(const benchmark::State& state) {
    return {static_cast<int>(state.range(0)), static_cast<int>(state.range(1))};
}

void count_pixels(benchmark::State& state) {
    state.SetItemsProcessed(state.iterations() * size_of(state).pixels());
}

void convert_to(benchmark::State& state, frame::PixelFormat format) {
    const frame::FrameRef frame = picture(size_of(state));
    std::vector<std::byte> out(bytes_of(format, size_of(state)));
    for ([[maybe_unused]] auto turn : state) {
        CHECK(convert(*frame, format, {}, out).has_value());
        benchmark::DoNotOptimize(out.data());
    }
    count_pixels(state);
}

/// The next frame of a standing camera: of each hundred rows so many changed since the last one, in one piece.
frame::FrameRef next_of(const frame::Frame& frame, int percent) {
    frame::FrameInfo info = frame.info();
    info.damage = frame::Damage::since(info.sequence);
    const int rows = info.size.height * percent / 100;
    info.damage.add((info.size.height - rows) / 2, (info.size.height + rows) / 2);
    return std::make_shared<const frame::Frame>(info, std::vector(frame.bytes().begin(), frame.bytes().end()));
}

void convert_changed(benchmark::State& state, frame::PixelFormat format, int percent) {
    frame::FramePool pool;
    const frame::FrameRef frame = picture(size_of(state)), next = next_of(*frame, percent);
    const auto last = converted(pool, frame, format, {});
    CHECK(last);
    for ([[maybe_unused]] auto turn : state) benchmark::DoNotOptimize(converted(pool, next, format, {}, *last));
    count_pixels(state);
}

void encode(benchmark::State& state, Result<std::unique_ptr<codec::Encoder>> encoder, frame::PixelFormat format) {
    frame::FramePool pool;
    const auto frame = converted(pool, picture(size_of(state)), format, {});
    CHECK(encoder && frame);
    for ([[maybe_unused]] auto turn : state) benchmark::DoNotOptimize((*encoder)->encode(**frame));
    count_pixels(state);
}

void jpeg(benchmark::State& state, frame::PixelFormat format,
          codec::ChromaSampling sampling = codec::ChromaSampling::yuv420) {
    encode(state, create_jpeg_encoder(codec::default_jpeg_quality, sampling), format);
}

void jpeg_changed(benchmark::State& state, int percent) {
    const frame::FrameRef frame = picture(size_of(state)), next = next_of(*frame, percent);
    auto encoder = codec::create_jpeg_encoder(codec::default_jpeg_quality);
    CHECK(encoder);
    benchmark::DoNotOptimize((*encoder)->encode(*frame));
    for ([[maybe_unused]] auto turn : state) benchmark::DoNotOptimize((*encoder)->encode(*next));
    count_pixels(state);
}

void png(benchmark::State& state) {
    encode(state, codec::create_png_encoder(), frame::PixelFormat::rgba8);
}

void code_strip(benchmark::State& state) {
    const frame::FrameRef frame = picture(size_of(state));
    std::vector<std::byte> pixels(frame->bytes().begin(), frame->bytes().end());
    std::uint32_t sequence = 0;
    for ([[maybe_unused]] auto turn : state) {
        frame::draw_code_strip(pixels, size_of(state), {.camera = 1, .sequence = ++sequence, .world_ns = 40'000'000});
        benchmark::DoNotOptimize(pixels.data());
    }
    state.SetItemsProcessed(state.iterations());
}

void sizes(benchmark::internal::Benchmark* bench) {
    bench->Args({640, 480})->Args({1920, 1080})->Unit(benchmark::kMicrosecond);
}

BENCHMARK_CAPTURE(convert_to, i420, frame::PixelFormat::i420)->Apply(sizes);
BENCHMARK_CAPTURE(convert_to, nv12, frame::PixelFormat::nv12)->Apply(sizes);
BENCHMARK_CAPTURE(convert_to, yuyv, frame::PixelFormat::yuyv)->Apply(sizes);
BENCHMARK_CAPTURE(convert_to, bgr24, frame::PixelFormat::bgr24)->Apply(sizes);
BENCHMARK_CAPTURE(convert_to, jpeg_i420, frame::PixelFormat::jpeg_i420)->Apply(sizes);
BENCHMARK_CAPTURE(convert_changed, i420_all_rows, frame::PixelFormat::i420, 100)->Apply(sizes);
BENCHMARK_CAPTURE(convert_changed, i420_half_of_the_rows, frame::PixelFormat::i420, 50)->Apply(sizes);
BENCHMARK_CAPTURE(convert_changed, i420_a_fifth_of_the_rows, frame::PixelFormat::i420, 20)->Apply(sizes);
BENCHMARK_CAPTURE(convert_changed, yuyv_half_of_the_rows, frame::PixelFormat::yuyv, 50)->Apply(sizes);
BENCHMARK_CAPTURE(jpeg, from_rgba8, frame::PixelFormat::rgba8)->Apply(sizes);
BENCHMARK_CAPTURE(jpeg, yuv422_from_rgba8, frame::PixelFormat::rgba8, codec::ChromaSampling::yuv422)->Apply(sizes);
BENCHMARK_CAPTURE(jpeg, from_yuv_planes, frame::PixelFormat::jpeg_i420)->Apply(sizes);
BENCHMARK_CAPTURE(jpeg_changed, half_of_the_rows, 50)->Apply(sizes);
BENCHMARK_CAPTURE(jpeg_changed, a_fifth_of_the_rows, 20)->Apply(sizes);
BENCHMARK_CAPTURE(jpeg_changed, no_row, 0)->Apply(sizes);
BENCHMARK(png)->Apply(sizes);
BENCHMARK(code_strip)->Apply(sizes);

}  // namespace
}  // namespace camrig::bench
