#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

#include "core/base/image_size.h"
#include "core/sensor/sensor_spec.h"

namespace camrig::sensor {

/// What falls on each photosite of a sensor, behind its filter: planes as those of its numbers, each row filled up with
/// darkness to whole pieces. Kept where light stays, it need not be gathered for every picture.
class SiteLight {
public:
    /// Floats of a row.
    static int stride_for(int width);
    static std::int64_t bytes_for(const SensorSpec& spec, ImageSize size);
    std::int64_t bytes() const { return std::ssize(sites_) * std::int64_t{sizeof(float)}; }

    /// Of a sensor with that filter, those responses and that size.
    bool is_for(const SensorSpec& spec, ImageSize size) const;
    /// Makes this one for that sensor, all dark.
    void fit(const SensorSpec& spec, ImageSize size);

    float* row(int plane, int y) { return sites_.data() + offset(plane, y); }
    const float* row(int plane, int y) const { return sites_.data() + offset(plane, y); }

private:
    std::ptrdiff_t offset(int plane, int y) const {
        return (std::ptrdiff_t{plane} * size_.height + y) * stride_for(size_.width);
    }

    ImageSize size_;
    ColorFilter filter_ = ColorFilter::rgb;
    std::array<double, 3> responses_{};
    std::vector<float> sites_;
};

}  // namespace camrig::sensor
