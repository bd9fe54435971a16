#pragma once

#include "core/render/gl/scene_items.h"

namespace camrig {

/// The world of one instant as the device has it.
struct PaintScene {
    std::uint64_t statics_number = 0;  ///< changes with the static set
    std::uint64_t objects_number = 0;  ///< changes with the objects in it
    SceneItems& statics;
    SceneItems& movers;
    const Environment& environment;
    std::span<const Light> lights;
    const LightTable& light_sets;
    StreamBuffer& stream;
};

}  // namespace camrig
