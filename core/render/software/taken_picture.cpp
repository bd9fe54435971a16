#include "core/render/software/taken_picture.h"

#include "core/sensor/frame_statistics.h"

namespace camrig::render::software {

void begin_taking(ViewWork& work, std::array<Plane<float>, 3>& light, std::vector<std::uint16_t>& numbers) {
    for (Plane<float>& plane : light) plane.fit(work.view->spec->size);
    work.canvas.light = light_rows(light);
    const std::size_t count = work.exposure->sensor->count();
    if (const auto& raw = work.channels[static_cast<std::size_t>(frame::FrameKind::sensor)].frame; raw != nullptr) {
        work.numbers = {reinterpret_cast<std::uint16_t*>(raw->mutable_bytes().data()), count};
    } else {
        if (numbers.size() < count) numbers.resize(count);
        work.numbers = {numbers.data(), count};
    }
}

void expose_rows(const ViewWork& work, const PixelRect& band) {
    const LightRows& light = work.canvas.light;
    work.exposure->sensor->expose({{light.red.data, light.green.data, light.blue.data}, light.red.stride},
                                  work.exposure->shot, band.y0, band.y1, work.numbers);
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
