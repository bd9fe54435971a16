#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/base/image_size.h"
#include "core/sensor/sensor_spec.h"

namespace camrig::sensor {

/// What the control loops see of a picture: black subtracted, 1 is the largest number, before white balance and tone.
struct FrameStatistics {
    static constexpr int columns = 5, rows = 3;
    /// Means of red, green and blue in a grid of zones, row by row. Of a sensor without filters all three are the same.
    std::array<std::array<double, 3>, columns * rows> zones{};
    double highlights = 0.0;  ///< mean of the brightest 2 % of the green photosites (of mono, of all)

    std::array<double, 3> mean() const;
    friend bool operator==(const FrameStatistics&, const FrameStatistics&) = default;
};

/// Of a large picture every other 2x2 block, or fewer, is looked at: up to about 65536 photosites a plane. Pictures of
/// fewer than 10x6 have zones without photosites, which are black.
FrameStatistics measure(const SensorSpec& spec, ImageSize size, std::span<const std::uint16_t> numbers);

}  // namespace camrig::sensor
