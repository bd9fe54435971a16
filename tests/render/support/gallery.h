#pragma once

#include <string>

#include "core/world/world.h"
#include "tests/render/support/test_rig.h"

/// What the rasterisers of a CPU are tried on.
namespace camrig::render {

/// Smooth and rough at once: gradients with a checker on them, alpha from 0 to 255.
world::Image patterned(ImageSize size);

/// A ball of so many rings with the normals of a sphere, texture coordinates and a colour per vertex.
world::Primitive ball(float radius, int rings);

/// A floor that reaches behind the camera and far away, and on it a surface of every sort: masked, blended,
/// double sided, mirrored, vertex colours, emission, occlusion, unlit, lights of all three kinds. Mirrored and glass
/// move.
TestWorld gallery();

/// The snapshot with all that stands still elsewhere.
world::SnapshotRef with_moved_objects(const world::SnapshotRef& from, const glm::dvec3& by);

/// A scene of the repository, told in instants. The statics of all snapshots are the same ones.
class Film {
public:
    /// baked_light: that which lies beside the scene, if any.
    explicit Film(const std::string& scene, bool baked_light = false);
    /// Instants must not go back.
    world::SnapshotRef at(TimeNs world_ns);
    /// The name of one of the scene's cameras, counted round.
    std::string camera(std::size_t index) const;
    /// The camera of the scene of this name, at this size.
    View view(const std::string& camera, ImageSize size, std::uint32_t number) const;

private:
    std::unique_ptr<world::World> world_;
};

}  // namespace camrig::render
