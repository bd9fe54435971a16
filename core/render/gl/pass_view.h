#pragma once

#include <span>

#include "core/render/gl/scene_items.h"
#include "core/render/shadow_plan.h"
#include "core/render/view_transform.h"

namespace camrig {

/// What one picture needs to know about the world around the draws.
struct PassView {
    ViewTransform transform;
    Frustum frustum;
    Quality quality = Quality::simple;
    double max_detail_error_px = 0.0;  ///< 0: every mesh in full
    const Environment* environment = nullptr;
    std::span<const Light> lights;
    const LightTable* light_sets = nullptr;
    std::span<const ShadowView> shadows;  ///< those of quality `beautiful`; else empty
    GLuint shadow_maps = 0;               ///< one layer for each
};

}  // namespace camrig
