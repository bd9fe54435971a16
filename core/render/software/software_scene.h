#pragma once

#include <deque>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "core/render/software/software_model.h"

namespace camrig {

/// Levels of detail of a primitive, as bits: 1 is the full mesh, with all vertices.
using LevelSet = std::uint32_t;

/// Vertices of one skinned or morphed primitive at one instant: made when the first camera sees them, used by all.
struct DeformedVertices {
    const PosedModel* pose = nullptr;
    int node = 0;
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
    LevelSet made = 0;  ///< of which levels the vertices are made

    /// Those of the levels that are not made yet.
    LevelSet missing(LevelSet levels) const { return (made & 1) != 0 ? 0 : levels & ~made; }
};

/// One draw placed in the world, the same for all cameras.
struct SoftwareItem {
    const SoftwareModel* model = nullptr;
    const SoftwarePrimitive* primitive = nullptr;
    glm::dmat4 world_from_local{1.0};
    Box bounds;  ///< local
    LightSet lights;
    bool is_mirrored = false;
    int deformation = -1;  ///< into SoftwareItems::deformations; -1: rigid
};

/// Models by identity, kept as long as anybody else holds them.
class SoftwareModels {
public:
    const SoftwareModel& model(const ModelRef& source);
    void evict_unused();

private:
    std::map<const Model*, std::unique_ptr<SoftwareModel>> models_;
};

/// All draws of some instances in their poses. Storage is reused from instant to instant.
class SoftwareItems {
public:
    void clear();
    void add(const Instance& instance, SoftwareModels& models, std::span<const Light> lights, float exposure);
    std::span<const SoftwareItem> items() const { return items_; }
    /// Makes the vertices of these levels of a deformed item. Different items from different threads; one item from one
    /// thread at a time.
    const DeformedVertices& deform(const SoftwareItem& item, LevelSet levels = 1);
    const DeformedVertices& deformed(const SoftwareItem& item) const;
    bool has_only_triangles() const { return has_only_triangles_; }
    std::uint64_t made() const;
    std::uint64_t unseen() const;

private:
    PosedModel& next_pose();
    DeformedVertices& next_deformation();
    void add_surface(const Instance& instance, const SoftwareModel& model, const PosedModel& pose,
                     const Surface& surface, std::span<const Light> lights, float exposure);

    std::vector<SoftwareItem> items_;
    std::deque<DeformedVertices> deformations_;
    std::deque<PosedModel> poses_;
    std::size_t deformations_used_ = 0, poses_used_ = 0;
    bool has_only_triangles_ = true;
};

}  // namespace camrig
