#pragma once

#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "core/base/ids.h"
#include "core/render/pixel_rect.h"
#include "core/world/model.h"
#include "core/world/posed_model.h"

/// Bodies as capsules, each about what one joint of a skin moves: what somebody keeps of the light from all around
/// from the ground and the walls beside him.
namespace camrig::render::scene {

struct SceneView;

/// All points that are no farther than the radius from a line between two points.
struct Capsule {
    glm::dvec3 from{0.0}, to{0.0};
    double radius_m = 0.0;
};

/// Of a joint, in its node's frame.
struct JointCapsule {
    int node = 0;
    Capsule capsule;
};

/// Of a model's skins: about the vertices that a joint moves most, along their longest axis and as wide as they are
/// on average. The largest of them, at most max_capsules_per_body; empty without a skin.
std::vector<JointCapsule> body_of(const world::Model& model);
inline constexpr std::size_t max_capsules_per_body = 16;

/// No light is kept from what is farther away than this from a capsule's surface.
inline constexpr double contact_reach_m = 0.5;

/// The capsules of bodies that stand somewhere.
class PlacedBodies {
public:
    struct Body {
        ObjectId object{};
        std::size_t first = 0, count = 0;  ///< into capsules()
        glm::dvec3 min{0.0}, max{0.0};     ///< in here it keeps light from things
    };
    void clear();
    void add(ObjectId object, std::span<const JointCapsule> body, const world::PosedModel& pose,
             const glm::dmat4& world_from_model);
    std::span<const Body> bodies() const { return bodies_; }
    std::span<const Capsule> capsules() const { return capsules_; }

private:
    std::vector<Body> bodies_;
    std::vector<Capsule> capsules_;
};

/// A capsule in the optical frame of a view, and whose it is: in memory as shaders/contact.glsl has them.
struct CapsuleInView {
    glm::vec3 from{0.0f};
    float radius = 0.0f;
    glm::vec3 along{0.0f};  ///< to the other end
    float length = 0.0f;
};
struct BodyInView {
    glm::vec3 middle{0.0f};  ///< of a ball in which it keeps light from things
    float radius2 = 0.0f;
    ObjectId object{};  ///< whose own surfaces it does not darken
    std::uint32_t first = 0, count = 0, is_moving = 0;
};
static_assert(sizeof(CapsuleInView) == 32 && sizeof(BodyInView) == 32);

/// The bodies that may darken something in a view.
struct BodiesInView {
    std::vector<BodyInView> bodies;
    std::vector<CapsuleInView> capsules;
    std::vector<PixelRect> moving_rects;  ///< every pixel of what those that move may darken
    void clear();
    void see(const SceneView& view, const PlacedBodies& statics, const PlacedBodies& movers);
};

}  // namespace camrig::render::scene
