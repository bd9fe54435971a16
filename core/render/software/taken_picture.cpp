#include "core/render/software/taken_picture.h"

#include "core/sensor/frame_statistics.h"

namespace camrig::render::software {
namespace {

sensor::Light light_of(const Canvas& canvas) {
    const LightRows& light = canvas.light;
    return {{light.red.data, light.green.data, light.blue.data}, light.red.stride};
}

}  // namespace

void begin_taking(ViewWork& work, std::array<Plane<float>, 3>& light, std::vector<std::uint16_t>& numbers) {
    work.has_sites = work.keeps_sites = false;
    for (Plane<float>& plane : light) plane.fit(work.view->spec->size);
    work.canvas.light = light_rows(light);
    const std::size_t count = work.exposure->sensor->count();
    if (const auto& raw = work.channels[index_of(frame::FrameKind::sensor)].frame; raw != nullptr) {
        work.numbers = {reinterpret_cast<std::uint16_t*>(raw->mutable_bytes().data()), count};
    } else {
        if (numbers.size() < count) numbers.resize(count);
        work.numbers = {numbers.data(), count};
    }
}

void look_at_light(ViewWork& work, const StaticLayer& layer, std::span<const PixelRect> rects) {
    work.has_sites = layer.sites.is_for(work.exposure->sensor->spec(), work.view->spec->size);
    if (!work.has_sites) return;
    work.drawn_tiles.clear(work.view->spec->size);
    mark_drawn(work, rects);
}

void mark_drawn(ViewWork& work, std::span<const PixelRect> rects) {
    work.new_tiles.clear();
    for (const PixelRect& rect : rects) work.drawn_tiles.mark(common(rect, work.whole), work.new_tiles);
}

void expose_rows(const ViewWork& work, const PixelRect& band) {
    const sensor::Sensor& sensor = *work.exposure->sensor;
    sensor::StandingLight standing;
    if (work.has_sites) {
        standing = {&work.layer->sites, &work.drawn_tiles};
    } else if (work.keeps_sites) {
        sensor.gather(light_of(work.layer->shown().canvas()), band.y0, band.y1, work.layer->sites);
    }
    sensor.expose(standing, light_of(work.canvas), work.exposure->shot, band.y0, band.y1, work.numbers);
}

void develop_rows(const ViewWork& work, const PixelRect& band) {
    const Rows<std::uint32_t> picture = rows_of(*work.frame);
    sensor::develop(work.exposure->sensor->spec(), work.view->spec->size, work.numbers, work.exposure->balance, band.y0,
                    band.y1, {picture.data, picture.stride});
}

void end_taking(const ViewWork& work) {
    if (work.view->sensor == nullptr) return;
    work.view->sensor->taken(*work.exposure,
                             sensor::measure(work.exposure->sensor->spec(), work.view->spec->size, work.numbers));
}

}  // namespace camrig::render::software
