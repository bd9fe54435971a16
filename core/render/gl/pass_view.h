#pragma once

#include <span>

#include "core/render/gl/gl_functions.h"
#include "core/render/gl/light_map.h"
#include "core/render/scene/body_capsules.h"
#include "core/render/scene/scene_view.h"
#include "core/render/shadow_plan.h"

namespace camrig::render::gl {

/// One picture of a scene, and the shadows in it.
struct PassView : scene::SceneView {
    std::span<const ShadowView> shadows;          ///< those of quality `beautiful`; else empty
    GLuint shadow_maps = 0;                       ///< one layer for each
    const scene::BodiesInView* bodies = nullptr;  ///< those of quality `beautiful`; null: none
    const LightMap* light_map = nullptr;          ///< of quality `beautiful`; null: the scene has no baked light
};

}  // namespace camrig::render::gl
