#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "core/render/software/canvas.h"
#include "core/render/software/pixel_part.h"
#include "core/render/software/place_shading.h"

/// Pixels that show several colours, each in a part of them: mixed in linear light.
namespace camrig::render::software {

constexpr float share_of(int samples) {
    return static_cast<float>(samples) * (1.0f / sample_count);
}
/// Linear light of a pixel as a picture has it.
glm::vec3 linear_of(std::uint32_t pixel);
/// Opaque; of a pixel's own light it is that pixel.
std::uint32_t pixel_of(const glm::vec3& linear);
glm::vec3 shown_by(const Canvas& canvas, int x, int y);

/// Pixels to mix, and of what. One after the other: begin(), what is in it, end().
class MixedPixels {
    /// Instead of a number among ShadedPlaces.
    static constexpr std::int32_t is_known = -1, is_behind = -2;

public:
    struct Pixel {
        std::int32_t x = 0, y = 0;
        std::uint32_t first = 0;  ///< of its parts; the next one's first is the end
    };
    /// What covers some places of a pixel; together the parts of a pixel cover all of it.
    struct Part {
        SampleMask mask = 0;
        float share = 0.0f;  ///< that these are of the pixel
        std::int32_t place = is_known;
        PixelPlane plane;
        glm::vec3 color{0.0f};
    };

    /// background: linear light of what nothing covers.
    void clear(const glm::vec3& background) {
        pixels_.clear();
        parts_.clear();
        background_ = background;
    }
    void begin(int x, int y) {
        pixels_.push_back({x, y, static_cast<std::uint32_t>(parts_.size())});
        left_ = all_samples;
    }
    [[gnu::always_inline]] inline void add(SampleMask mask, const PixelPlane& plane, const glm::vec3& color) {
        add(mask, plane, is_known, color);
    }
    /// place: of ShadedPlaces, which may be shaded later.
    [[gnu::always_inline]] inline void add_place(SampleMask mask, const PixelPlane& plane, std::uint32_t place) {
        add(mask, plane, static_cast<std::int32_t>(place), {});
    }
    /// What the picture shows there before it is mixed (take_behind).
    [[gnu::always_inline]] inline void add_behind(SampleMask mask, const PixelPlane& plane) {
        add(mask, plane, is_behind, {});
    }
    void end() {
        if (left_ != 0) add(left_, {}, background_);
    }

    /// From left to right and top to bottom, as they were begun.
    std::span<const Pixel> pixels() const { return pixels_; }
    std::span<const Part> parts_of(std::size_t pixel) const {
        const std::size_t end = pixel + 1 < pixels_.size() ? pixels_[pixel + 1].first : parts_.size();
        return std::span(parts_).subspan(pixels_[pixel].first, end - pixels_[pixel].first);
    }
    static glm::vec3 color_of(const Part& part, const ShadedPlaces& places) {
        return part.place < 0 ? part.color : places.colors[static_cast<std::size_t>(part.place)];
    }

    /// Sets their numbers to 0: nothing else is to be shaded there.
    void leave_out(Rows<std::uint32_t> numbers) const;
    /// What lies behind has the colour that the picture has now.
    void take_behind(const Canvas& canvas);
    void mix(const ShadedPlaces& places, const Canvas& canvas) const;

private:
    [[gnu::always_inline]] inline void add(SampleMask mask, const PixelPlane& plane, std::int32_t place,
                                           const glm::vec3& color) {
        parts_.push_back({mask, share_of(std::popcount(mask)), place, plane, color});
        left_ &= ~mask;
    }

    std::vector<Pixel> pixels_;
    std::vector<Part> parts_;
    glm::vec3 background_{0.0f};
    SampleMask left_ = 0;
};

}  // namespace camrig::render::software
