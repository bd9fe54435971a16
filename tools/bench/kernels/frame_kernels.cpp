// What happens to a picture after it was drawn: colour conversion, JPEG, PNG, code strip. Run from the repository.
#include <benchmark/benchmark.h>

#include "core/codec/encoder.h"
#include "core/frame/code_strip.h"
#include "core/frame/convert.h"
#include "core/render/renderer_factory.h"
#include "core/world/world.h"

namespace camrig {
namespace {

/// A picture of the hall: codecs take as long as what they are given is rich. Aborts where there is no CPU rasteriser.
FrameRef picture(ImageSize size) {
    static std::map<std::pair<int, int>, FrameRef> made;
    FrameRef& frame = made[{size.width, size.height}];
    if (frame) return frame;
    const auto scene = load_scene("scenes/hall.json");
    CHECK(scene.has_value());
    auto world = World::create(*scene, 1);
    auto renderer = create_renderer({.device = "cpu", .pool = std::make_shared<FramePool>()});
    CHECK(world.has_value() && renderer.has_value());
    const Place& place = (*scene)->places.at("lobby");
    auto spec = std::make_shared<CameraSpec>();
    spec->name = "lobby";
    spec->size = size;
    spec->intrinsics = *intrinsics_from_vfov(size, place.vfov_rad);
    View view;
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

void convert_to(benchmark::State& state, PixelFormat format) {
    const FrameRef frame = picture(size_of(state));
    std::vector<std::byte> out(bytes_of(format, size_of(state)));
    for ([[maybe_unused]] auto turn : state) {
        CHECK(convert(*frame, format, {}, out).has_value());
        benchmark::DoNotOptimize(out.data());
    }
    count_pixels(state);
}

/// The next frame of a standing camera: of each hundred rows so many changed since the last one, in one piece.
FrameRef next_of(const Frame& frame, int percent) {
    FrameInfo info = frame.info();
    info.damage = Damage::since(info.sequence);
    const int rows = info.size.height * percent / 100;
    info.damage.add((info.size.height - rows) / 2, (info.size.height + rows) / 2);
    return std::make_shared<const Frame>(info, std::vector(frame.bytes().begin(), frame.bytes().end()));
}

void convert_changed(benchmark::State& state, PixelFormat format, int percent) {
    FramePool pool;
    const FrameRef frame = picture(size_of(state)), next = next_of(*frame, percent);
    const auto last = converted(pool, frame, format, {});
    CHECK(last);
    for ([[maybe_unused]] auto turn : state) benchmark::DoNotOptimize(converted(pool, next, format, {}, *last));
    count_pixels(state);
}

void encode(benchmark::State& state, Result<std::unique_ptr<Encoder>> encoder, PixelFormat format) {
    FramePool pool;
    const auto frame = converted(pool, picture(size_of(state)), format, {});
    CHECK(encoder && frame);
    for ([[maybe_unused]] auto turn : state) benchmark::DoNotOptimize((*encoder)->encode(**frame));
    count_pixels(state);
}

void jpeg(benchmark::State& state, PixelFormat format, ChromaSampling sampling = ChromaSampling::yuv420) {
    encode(state, create_jpeg_encoder(default_jpeg_quality, sampling), format);
}

void jpeg_changed(benchmark::State& state, int percent) {
    const FrameRef frame = picture(size_of(state)), next = next_of(*frame, percent);
    auto encoder = create_jpeg_encoder(default_jpeg_quality);
    CHECK(encoder);
    benchmark::DoNotOptimize((*encoder)->encode(*frame));
    for ([[maybe_unused]] auto turn : state) benchmark::DoNotOptimize((*encoder)->encode(*next));
    count_pixels(state);
}

void png(benchmark::State& state) {
    encode(state, create_png_encoder(), PixelFormat::rgba8);
}

void code_strip(benchmark::State& state) {
    const FrameRef frame = picture(size_of(state));
    std::vector<std::byte> pixels(frame->bytes().begin(), frame->bytes().end());
    std::uint32_t sequence = 0;
    for ([[maybe_unused]] auto turn : state) {
        draw_code_strip(pixels, size_of(state), {.camera = 1, .sequence = ++sequence, .world_ns = 40'000'000});
        benchmark::DoNotOptimize(pixels.data());
    }
    state.SetItemsProcessed(state.iterations());
}

void sizes(benchmark::internal::Benchmark* bench) {
    bench->Args({640, 480})->Args({1920, 1080})->Unit(benchmark::kMicrosecond);
}

BENCHMARK_CAPTURE(convert_to, i420, PixelFormat::i420)->Apply(sizes);
BENCHMARK_CAPTURE(convert_to, nv12, PixelFormat::nv12)->Apply(sizes);
BENCHMARK_CAPTURE(convert_to, yuyv, PixelFormat::yuyv)->Apply(sizes);
BENCHMARK_CAPTURE(convert_to, bgr24, PixelFormat::bgr24)->Apply(sizes);
BENCHMARK_CAPTURE(convert_to, jpeg_i420, PixelFormat::jpeg_i420)->Apply(sizes);
BENCHMARK_CAPTURE(convert_changed, i420_all_rows, PixelFormat::i420, 100)->Apply(sizes);
BENCHMARK_CAPTURE(convert_changed, i420_half_of_the_rows, PixelFormat::i420, 50)->Apply(sizes);
BENCHMARK_CAPTURE(convert_changed, i420_a_fifth_of_the_rows, PixelFormat::i420, 20)->Apply(sizes);
BENCHMARK_CAPTURE(convert_changed, yuyv_half_of_the_rows, PixelFormat::yuyv, 50)->Apply(sizes);
BENCHMARK_CAPTURE(jpeg, from_rgba8, PixelFormat::rgba8)->Apply(sizes);
BENCHMARK_CAPTURE(jpeg, yuv422_from_rgba8, PixelFormat::rgba8, ChromaSampling::yuv422)->Apply(sizes);
BENCHMARK_CAPTURE(jpeg, from_yuv_planes, PixelFormat::jpeg_i420)->Apply(sizes);
BENCHMARK_CAPTURE(jpeg_changed, half_of_the_rows, 50)->Apply(sizes);
BENCHMARK_CAPTURE(jpeg_changed, a_fifth_of_the_rows, 20)->Apply(sizes);
BENCHMARK_CAPTURE(jpeg_changed, no_row, 0)->Apply(sizes);
BENCHMARK(png)->Apply(sizes);
BENCHMARK(code_strip)->Apply(sizes);

}  // namespace
}  // namespace camrig
