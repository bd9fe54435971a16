#pragma once

#include "core/world/scene.h"

namespace camrig {

/// A bare model as a scene: one object `model` (a mover that loops the first clip, if there is one), the model's lights
/// or else a default sun, the model's perspective cameras or else one camera `main` that sees all of it.
Result<Scene> scene_of_model(ModelRef model);

}  // namespace camrig
