#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "core/render/scene/prepared_model.h"
#include "core/world/posed_model.h"

/// What feet keep from the ground of the light that comes from all around: without it people seem to float.
///
/// Each part of a skinned model that is near the ground has a soft dark patch under it, and all of them together a
/// wider one; both pale as the parts rise. The ground is where the model's own z is 0, on which people walk. Patches
/// are blended surfaces like any other, so every renderer has them, they cost a few blended pixels, and depth, ids and
/// truth know nothing of them.
namespace camrig::render::scene {

/// The patches: square pictures from -1 to 1 in x and y at z = 0, seen from above. Its primitive k darkens by
/// (k + 1) / contact_shades of what the darkest does.
const world::ModelRef& contact_model();
inline constexpr int contact_shades = 8;

struct ContactShadow {
    glm::dmat4 model_from_patch{1.0};
    int shade = 0;  ///< a primitive of contact_model()
};

/// Those of a model in a pose. `to` is reused.
void find_contact_shadows(const world::Model& model, const PreparedModel& prepared, const world::PosedModel& pose,
                          std::vector<ContactShadow>& to);

}  // namespace camrig::render::scene
