#pragma once

#include "core/world/scene.h"

namespace camrig::world {

/// A bare model as a scene: one object `model` (a mover that loops the first clip, if there is one), the model's lights
/// or else a default sun, the model's perspective cameras or else one camera `main` that sees all of it. With
/// `bare_ground`, objects `ground` and `sky`: the ground lies just below the lowest point of the first picture, so it
/// covers nothing that the file brings, and the sky is beyond all of it.
Result<Scene> scene_of_model(ModelRef model, const SceneOptions& options = {});

}  // namespace camrig::world
