#pragma once

#include <optional>

#include "core/render/gl/draw_pass.h"
#include "core/render/gl/gl_objects.h"
#include "core/render/shadow_plan.h"

namespace camrig::render::gl {

/// Shadow maps of one instant, shared by all cameras.
///
/// Two layers of depth for each light: `still`, of what stands still, drawn when that or the light changes; `now`, a
/// copy of it with the movers in it, of which only the rectangles that movers touch are made anew each instant. Where
/// no mover casts a shadow both hold the same texels: the static layers of cameras live on that.
class ShadowMaps {
public:
    explicit ShadowMaps(const GlFunctions& gl) : gl_(gl) {}

    /// Draws what has changed. Where the device has no memory for maps there are no shadows, and a line in the log.
    void update(GpuScene& scene, DrawPass& pass, bool has_detail_levels);

    std::span<const ShadowView> views() const { return views_; }
    GLuint still() const { return still_.name(); }
    GLuint now() const { return now_.name(); }
    /// Every pixel of a view whose look at `now` and at `still` may differ.
    std::vector<PixelRect> changed_pixels(const ViewTransform& view) const;

private:
    Result<void> plan(const scene::PlacedScene& scene);
    void copy_from_still(std::size_t layer, const PixelRect& rect);

    const GlFunctions& gl_;
    std::uint64_t statics_number_ = 0, objects_number_ = 0;
    std::vector<ShadowView> views_;
    WorldBox receivers_;
    GlTexture still_, now_;
    std::vector<GlFramebuffer> still_targets_, now_targets_;  ///< per layer
    std::vector<std::vector<PixelRect>> dirty_;               ///< per layer: where `now` has movers in it
    std::vector<WorldBox> casters_;                           ///< the movers
};

}  // namespace camrig::render::gl
