#pragma once

#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "core/world/model.h"

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

/// Those of one model in its pose, found from its parts. Reused from model to model, it takes no memory anew.
class ContactShadows {
public:
    /// Another model.
    void begin();
    /// Where in the model's frame something lies that a joint moves; once for each primitive with vertices of it.
    void add(int joint, const world::Box& box);
    /// Of all parts since begin(); until the next call.
    std::span<const ContactShadow> find();

private:
    /// Of a part, or of all: where it lies over the ground, and the height of its underside.
    struct Footprint {
        int joint = -1;
        glm::dvec2 min{0.0}, max{0.0};
        double height_m = 0.0;
        void join(const Footprint& other);
    };
    void add_shadow(const Footprint& of, double margin_m, double darkest);

    std::vector<Footprint> parts_;
    std::optional<Footprint> all_;
    std::vector<ContactShadow> shadows_;
};

}  // namespace camrig::render::scene
