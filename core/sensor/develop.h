#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/image_size.h"
#include "core/sensor/expose_row.h"
#include "core/sensor/sensor_spec.h"

namespace camrig::sensor {

/// What red, green and blue are multiplied by, so that white is grey. The smallest is 1: what is saturated is white.
struct WhiteBalance {
    std::array<double, 3> gains{1.0, 1.0, 1.0};
    friend bool operator==(const WhiteBalance&, const WhiteBalance&) = default;

    /// Undoes the responses of the filters for light of this temperature.
    static WhiteBalance of_kelvin(const SensorSpec& spec, double kelvin);
    /// Gains in the proportions given, the smallest 1.
    static WhiteBalance normalised(const std::array<double, 3>& gains);
};

/// Rows of 8-bit pictures: red, green, blue, 255.
struct Rgba8Rows {
    std::uint32_t* pixels = nullptr;
    std::ptrdiff_t stride = 0;  ///< pixels from a row to the next
};

/// A camera's numbers as a picture: black subtracted, of a mosaic the missing colours interpolated from the photosites
/// around (bilinear), white balance, sRGB (IEC 61966-2-1, to 0.03 of a code). The largest number is white.
///
/// Rows first_row to end_row; rows above and below are read. Any thread, the same bytes on any processor.
void develop(const SensorSpec& spec, ImageSize size, std::span<const std::uint16_t> numbers,
             const WhiteBalance& balance, int first_row, int end_row, const Rgba8Rows& to, bool wide = has_wide_rows());

}  // namespace camrig::sensor
