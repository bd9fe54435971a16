#include "core/render/software/mixed_pixels.h"

#include <algorithm>

#include "core/render/software/rasterizer.h"
#include "core/render/software/shading.h"

namespace camrig::render::software {

glm::vec3 linear_of(std::uint32_t pixel) {
    const std::array<float, 256>& linear = linear_of_code();
    return {linear[pixel & 0xFF], linear[pixel >> 8 & 0xFF], linear[pixel >> 16 & 0xFF]};
}

std::uint32_t pixel_of(const glm::vec3& linear) {
    return srgb_code(linear.r) | std::uint32_t{srgb_code(linear.g)} << 8 | std::uint32_t{srgb_code(linear.b)} << 16 |
           0xFFu << 24;
}

glm::vec3 shown_by(const Canvas& canvas, int x, int y) {
    const LightRows& light = canvas.light;
    if (light) return {light.red(y)[x], light.green(y)[x], light.blue(y)[x]};
    return linear_of(canvas.color(y)[x]);
}

void MixedPixels::leave_out(Rows<std::uint32_t> numbers) const {
    for (const Pixel& pixel : pixels_) numbers(pixel.y)[pixel.x] = 0;
}

void MixedPixels::take_behind(const Canvas& canvas) {
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        const std::size_t end = i + 1 < pixels_.size() ? pixels_[i + 1].first : parts_.size();
        for (std::size_t k = pixels_[i].first; k < end; ++k) {
            if (parts_[k].place != is_behind) continue;
            parts_[k].place = is_known;
            parts_[k].color = shown_by(canvas, pixels_[i].x, pixels_[i].y);
        }
    }
}

void MixedPixels::mix(const ShadedPlaces& places, const Canvas& canvas) const {
    for (std::size_t first = 0; first < pixels_.size(); first += lane_count) {
        const std::size_t end = std::min(first + lane_count, pixels_.size());
        Lanes3 light{};
        for (std::size_t i = first; i < end; ++i) {
            glm::vec3 sum(0.0f);
            for (const Part& part : parts_of(i)) sum += part.share * color_of(part, places);
            if (canvas.light) {
                canvas.light.red(pixels_[i].y)[pixels_[i].x] = sum.x;
                canvas.light.green(pixels_[i].y)[pixels_[i].x] = sum.y;
                canvas.light.blue(pixels_[i].y)[pixels_[i].x] = sum.z;
                continue;
            }
            const auto lane = static_cast<int>(i - first);
            light.x[lane] = sum.x;
            light.y[lane] = sum.y;
            light.z[lane] = sum.z;
        }
        if (canvas.light) continue;
        const IntLanes codes = pixels_of({srgb(light.x), srgb(light.y), srgb(light.z)});
        for (std::size_t i = first; i < end; ++i)
            canvas.color(pixels_[i].y)[pixels_[i].x] = static_cast<std::uint32_t>(codes[static_cast<int>(i - first)]);
    }
}

}  // namespace camrig::render::software
