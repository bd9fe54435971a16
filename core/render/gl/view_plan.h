#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/render/gl/lens_cache.h"
#include "core/render/gl/view_target.h"
#include "core/render/pixel_rect.h"
#include "core/render/renderer.h"

namespace camrig::render::gl {

/// The finished pictures of one camera in one instant; they live until the instant was read.
struct ViewTargets {
    std::optional<ColorTarget> color;
    std::optional<TruthTarget> truth;
    /// The kept picture that `color` shows outside of `changed` (StaticLayers::Layer::number); 0: none.
    std::uint64_t shown_layer = 0;
    std::vector<PixelRect> changed;
};

/// How one view is drawn.
struct ViewPlan {
    const world::CameraSpec* spec = nullptr;
    std::shared_ptr<const LensOnDevice> lens{};
    std::span<const SourceTile> tiles{};
    ImageSize source{};  ///< at one texel per pixel
    int supersampling = 1;
    int multisampling = 1;
    bool is_bicubic = false;
    bool wants_color = false;
    bool wants_truth = false;             ///< the scene is drawn again, for ids, normals and depth
    bool takes_depth_from_color = false;  ///< no second pass: depth is read from the colour pass
    bool is_resampled() const { return lens != nullptr || supersampling * multisampling > 1; }
};

/// The source pictures of one view, and what is drawn into them now; null: nothing.
struct ViewSources {
    const ColorTarget* color = nullptr;
    const TruthTarget* truth = nullptr;
};

inline ImageSize scaled(ImageSize size, int factor) {
    return {size.width * factor, size.height * factor};
}

}  // namespace camrig::render::gl
