#pragma once

#include <array>
#include <deque>
#include <map>
#include <span>
#include <vector>

#include "core/render/gl/gpu_model.h"
#include "core/render/gl/stream_buffer.h"
#include "core/render/light_selection.h"
#include "core/render/placement.h"
#include "core/world/posed_model.h"
#include "core/world/snapshot.h"

namespace camrig {

/// Vertices of one skinned or morphed primitive at one instant: made when the first camera sees them, used by all.
struct Deformation {
    const Model* model = nullptr;  ///< held by the instance
    const PosedModel* pose = nullptr;
    int node = 0;
    StreamBuffer::Piece positions;
    StreamBuffer::Piece normals;
    bool is_done = false;
};

/// One draw placed in the world, the same for all cameras.
struct SceneItem {
    const GpuModel* model = nullptr;
    const GpuPrimitive* primitive = nullptr;
    const GpuMaterial* material = nullptr;
    glm::dmat4 world_from_local{1.0};
    Box bounds;  ///< local
    ObjectId object{};
    bool is_mirrored = false;
    int light_set = 0;                 ///< into LightTable
    int deformation = -1;              ///< into SceneItems::deformations; -1: rigid
    ShaderKey key;                     ///< all but the quality
    std::array<GLuint, 3> programs{};  ///< per Quality; 0 until first drawn
};

/// The different light sets of an instant; few, because neighbours share theirs.
class LightTable {
public:
    int add(const LightSet& set);
    const LightSet& operator[](int index) const { return sets_[static_cast<std::size_t>(index)]; }
    int size() const { return static_cast<int>(sets_.size()); }
    void truncate(int size) { sets_.resize(static_cast<std::size_t>(size)); }

private:
    std::vector<LightSet> sets_;
};

/// Uploaded models by identity, kept as long as anybody holds the Model. The cache does not: several renderers keep one
/// each, and none of them would ever see the last holder go.
class ModelCache {
public:
    ModelCache(const GlFunctions& gl, SamplerCache& samplers) : gl_(gl), samplers_(samplers) {}
    const GpuModel& model(const ModelRef& model);
    /// Frees the models that are gone.
    void evict_unused();
    std::size_t size() const { return models_.size(); }

private:
    const GlFunctions& gl_;
    SamplerCache& samplers_;
    std::map<const Model*, GpuModel> models_;
};

/// All draws of some instances in their poses.
struct SceneItems {
    std::vector<SceneItem> items;
    std::vector<Deformation> deformations;
    std::deque<PosedModel> poses;  ///< storage, reused between instants
    std::size_t poses_used = 0;

    void clear();
    void add(const Instance& instance, ModelCache& models, LightTable& light_sets, std::span<const Light> lights,
             float exposure, StreamBuffer& stream);
    /// Makes the vertices of a deformed item if nobody did.
    const Deformation& deformed(const SceneItem& item, StreamBuffer& stream);

private:
    PosedModel& next_pose();
    void add_surface(const Instance& instance, const GpuModel& model, const PosedModel& pose, const Surface& surface,
                     LightTable& light_sets, std::span<const Light> lights, float exposure, StreamBuffer& stream);
};

}  // namespace camrig
