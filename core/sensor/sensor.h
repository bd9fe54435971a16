#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/image_size.h"
#include "core/base/result.h"
#include "core/base/tile_set.h"
#include "core/camera/intrinsics.h"
#include "core/sensor/expose_row.h"
#include "core/sensor/sensor_spec.h"
#include "core/sensor/site_light.h"

namespace camrig::sensor {

/// Linear light on the focal plane, not clamped: red, green and blue, 1 is what white of the scene is drawn as.
struct Light {
    const float* planes[3] = {};
    std::ptrdiff_t stride = 0;  ///< floats from a row to the next
};

/// Light that stays, and where in the picture it is another; without them it is another everywhere.
struct StandingLight {
    const SiteLight* sites = nullptr;
    const TileSet* but_in = nullptr;
};

/// How one picture is taken.
struct Shot {
    std::int64_t frame = 0;  ///< its number: noise differs with it
    double exposure_s = 0.01;
    double gain_db = 0.0;
};

/// From light to the numbers of a camera's converter. A pure function of spec, size, intrinsics, light and shot: the
/// same numbers however rows are shared out, on any processor.
///
/// Thread: any, as many at once as rows are apart. Error invalid_argument: a figure out of its range, named.
class Sensor {
public:
    static Result<Sensor> create(const SensorSpec& spec, ImageSize size, const camera::Intrinsics& intrinsics);

    const SensorSpec& spec() const { return spec_; }
    ImageSize size() const { return size_; }
    /// Numbers an electron is converted to.
    double numbers_per_e(double gain_db) const;
    /// Numbers of a whole picture: planes one after the other, rows from the top, no gaps.
    std::size_t count() const { return static_cast<std::size_t>(size_.pixels() * spec_.planes()); }

    /// Rows first_row to end_row of all planes. Light that is negative or no number counts as dark. `wide`:
    /// has_wide_rows(), or false for tests.
    void expose(const Light& light, const Shot& shot, int first_row, int end_row, std::span<std::uint16_t> numbers,
                bool wide = has_wide_rows()) const;
    /// The same of light that stands, which is_for this sensor; `light` is looked at where it does not.
    void expose(const StandingLight& standing, const Light& light, const Shot& shot, int first_row, int end_row,
                std::span<std::uint16_t> numbers, bool wide = has_wide_rows()) const;
    /// Rows first_row to end_row of all planes, into one that is_for this sensor.
    void gather(const Light& light, int first_row, int end_row, SiteLight& to) const;

    struct HotPixel {
        int plane = 0, y = 0, x = 0;
        double e_per_s = 0.0;
        friend bool operator==(const HotPixel&, const HotPixel&) = default;
    };
    /// By plane, row and column.
    std::span<const HotPixel> hot_pixels() const { return hot_; }

private:
    Sensor(const SensorSpec& spec, ImageSize size, const camera::Intrinsics& intrinsics);
    RowExposure row_of(const Shot& shot, int plane, int y) const;
    void gather_row(const Light& light, int plane, int y, int x0, int x1, float* to) const;
    const float* row_of_light(const StandingLight& standing, const Light& light, int plane, int y, float* row) const;

    SensorSpec spec_;
    ImageSize size_;
    camera::Intrinsics intrinsics_;
    std::vector<HotPixel> hot_;
};

}  // namespace camrig::sensor
