#pragma once

#include <functional>
#include <vector>

#include "core/sensor/sensor.h"

namespace camrig::sensor {

/// Light given as arrays.
struct GivenLight {
    std::vector<float> values[3];
    ImageSize size;

    explicit GivenLight(ImageSize s, float red, float green, float blue) : size(s) {
        const float colors[3] = {red, green, blue};
        for (std::size_t c = 0; c < 3; ++c) values[c].assign(static_cast<std::size_t>(s.pixels()), colors[c]);
    }
    GivenLight(ImageSize s, float grey) : GivenLight(s, grey, grey, grey) {}
    Light light() const { return {{values[0].data(), values[1].data(), values[2].data()}, size.width}; }
};

using Numbers = std::vector<std::uint16_t>;

inline Sensor sensor_of(const SensorSpec& spec, ImageSize size) {
    auto made = Sensor::create(spec, size, *camera::intrinsics_from_vfov(size, 1.0));
    CHECK(made.has_value());
    return *made;
}

inline Numbers taken(const Sensor& sensor, const Light& light, const Shot& shot) {
    Numbers numbers(sensor.count());
    sensor.expose(light, shot, 0, sensor.size().height, numbers);
    return numbers;
}

/// A mono sensor with these wells and 16 bits, without noise but that of light.
inline SensorSpec plain_mono(double full_well_e, int bits = 16) {
    SensorSpec spec;
    spec.filter = ColorFilter::mono;
    spec.full_well_e = full_well_e;
    spec.bits = bits;
    spec.seed = 7;
    return spec;
}

inline double mean_of(const Numbers& numbers) {
    double sum = 0.0;
    for (const std::uint16_t number : numbers) sum += number;
    return sum / static_cast<double>(numbers.size());
}

/// The variance of one picture's noise, from the difference of two: fixed patterns cancel.
inline double variance_of(const Numbers& a, const Numbers& b) {
    double sum = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double difference = static_cast<double>(a[i]) - b[i];
        sum += difference;
        squares += difference * difference;
    }
    const auto n = static_cast<double>(a.size());
    return (squares / n - sum * sum / (n * n)) / 2.0;
}

}  // namespace camrig::sensor
