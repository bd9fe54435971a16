#include "core/sensor/site_light.h"

#include "core/sensor/expose_row.h"

namespace camrig::sensor {

int SiteLight::stride_for(int width) {
    return (width + row_piece - 1) / row_piece * row_piece;
}

std::int64_t SiteLight::bytes_for(const SensorSpec& spec, ImageSize size) {
    return std::int64_t{stride_for(size.width)} * size.height * spec.planes() * std::int64_t{sizeof(float)};
}

bool SiteLight::is_for(const SensorSpec& spec, ImageSize size) const {
    return !sites_.empty() && size_ == size && filter_ == spec.filter && responses_ == spec.responses();
}

void SiteLight::fit(const SensorSpec& spec, ImageSize size) {
    size_ = size;
    filter_ = spec.filter;
    responses_ = spec.responses();
    sites_.assign(static_cast<std::size_t>(bytes_for(spec, size)) / sizeof(float), 0.0f);
}

}  // namespace camrig::sensor
