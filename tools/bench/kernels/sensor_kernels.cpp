// From light to a camera's numbers and picture, by sensor and by how much light there is.
#include <benchmark/benchmark.h>

#include "core/base/result.h"
#include "core/sensor/develop.h"
#include "core/sensor/frame_statistics.h"
#include "core/sensor/sensor.h"

namespace camrig::bench {
namespace {

/// Arguments: width, height, electrons under green in the middle of the picture, preset.
struct Taken {
    explicit Taken(const benchmark::State& state)
        : size{static_cast<int>(state.range(0)), static_cast<int>(state.range(1))},
          spec(sensor::sensor_preset(static_cast<sensor::SensorPreset>(state.range(3)))),
          made(sensor::Sensor::create(spec, size, *camera::intrinsics_from_vfov(size, 1.0))),
          light(static_cast<std::size_t>(size.pixels()), static_cast<float>(state.range(2) / spec.full_well_e)),
          numbers(made->count()) {}
    void expose(std::int64_t frame, bool wide) {
        made->expose({{light.data(), light.data(), light.data()}, size.width}, {.frame = frame}, 0, size.height,
                     numbers, wide);
    }

    ImageSize size;
    sensor::SensorSpec spec;
    Result<sensor::Sensor> made;
    std::vector<float> light;
    std::vector<std::uint16_t> numbers;
};

void sensor_noise(benchmark::State& state, bool wide) {
    Taken taken(state);
    std::int64_t frame = 0;
    for ([[maybe_unused]] auto turn : state) {
        taken.expose(frame++, wide);
        benchmark::DoNotOptimize(taken.numbers.data());
    }
    state.SetItemsProcessed(state.iterations() * taken.size.pixels());
}

void sensor_develop(benchmark::State& state) {
    Taken taken(state);
    taken.expose(0, sensor::has_wide_rows());
    std::vector<std::uint32_t> picture(taken.light.size());
    const auto balance = sensor::WhiteBalance::of_kelvin(taken.spec, 6500.0);
    for ([[maybe_unused]] auto turn : state) {
        sensor::develop(taken.spec, taken.size, taken.numbers, balance, 0, taken.size.height,
                        {picture.data(), taken.size.width});
        benchmark::DoNotOptimize(picture.data());
    }
    state.SetItemsProcessed(state.iterations() * taken.size.pixels());
}

void sensor_measure(benchmark::State& state) {
    Taken taken(state);
    taken.expose(0, sensor::has_wide_rows());
    for ([[maybe_unused]] auto turn : state)
        benchmark::DoNotOptimize(sensor::measure(taken.spec, taken.size, taken.numbers));
}

constexpr auto imx219 = static_cast<int>(sensor::SensorPreset::imx219);
constexpr auto imx249 = static_cast<int>(sensor::SensorPreset::imx249);

void sensor_sizes_and_light(benchmark::internal::Benchmark* bench) {
    for (const int preset : {imx219, imx249})
        for (const int electrons : {5, 14, 1000})
            for (const auto& [width, height] : {std::pair{640, 480}, {1920, 1080}})
                bench->Args({width, height, electrons, preset});
    bench->Unit(benchmark::kMillisecond);
}
void sensor_sizes(benchmark::internal::Benchmark* bench) {
    for (const auto& [width, height] : {std::pair{640, 480}, {1920, 1080}})
        bench->Args({width, height, 1000, imx219})->Args({width, height, 1000, imx249});
    bench->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(sensor_noise, wide, sensor::has_wide_rows())->Apply(sensor_sizes_and_light);
BENCHMARK_CAPTURE(sensor_noise, plain, false)->Apply(sensor_sizes_and_light);
BENCHMARK(sensor_develop)->Apply(sensor_sizes);
BENCHMARK(sensor_measure)->Apply(sensor_sizes);

}  // namespace
}  // namespace camrig::bench
