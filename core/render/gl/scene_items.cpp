#include "core/render/gl/scene_items.h"

#include <algorithm>

namespace camrig {

int LightTable::add(const LightSet& set) {
    const auto found = std::ranges::find(sets_, set);
    if (found != sets_.end()) return static_cast<int>(found - sets_.begin());
    sets_.push_back(set);
    return size() - 1;
}

const GpuModel& ModelCache::model(const ModelRef& model) {
    const auto found = models_.find(model.get());
    if (found == models_.end()) return models_.emplace(model.get(), upload_model(gl_, samplers_, model)).first->second;
    // A new model may lie where one that is gone has been.
    if (found->second.source.expired()) found->second = upload_model(gl_, samplers_, model);
    return found->second;
}

void ModelCache::evict_unused() {
    std::erase_if(models_, [](const auto& entry) { return entry.second.source.expired(); });
}

void SceneItems::clear() {
    items.clear();
    deformations.clear();
    poses_used = 0;
}

PosedModel& SceneItems::next_pose() {
    if (poses_used == poses.size()) poses.emplace_back();
    return poses[poses_used++];
}

void SceneItems::add(const Instance& instance, ModelCache& models, LightTable& light_sets,
                     std::span<const Light> lights, float exposure, StreamBuffer& stream) {
    const ModelRef& source = instance.info->model;
    if (source == nullptr) return;
    const GpuModel& model = models.model(source);
    PosedModel& pose = next_pose();
    pose_model(*source, instance.clips, pose);
    for (const Surface& surface : model.surfaces) {
        add_surface(instance, model, pose, surface, light_sets, lights, exposure, stream);
    }
}

void SceneItems::add_surface(const Instance& instance, const GpuModel& model, const PosedModel& pose,
                             const Surface& surface, LightTable& light_sets, std::span<const Light> lights,
                             float exposure, StreamBuffer& stream) {
    const int node = surface.node;
    const Model& asset = *instance.info->model;
    const Node& source = asset.nodes[static_cast<std::size_t>(node)];
    const bool deforms = is_deformed(asset, node);
    const glm::dmat4 world = world_from_model(instance);
    const GpuPrimitive& primitive =
        model.meshes[static_cast<std::size_t>(source.mesh)][static_cast<std::size_t>(surface.primitive)];
    SceneItem item;
    item.model = &model;
    item.primitive = &primitive;
    item.material = &model.materials[static_cast<std::size_t>(primitive.material)];
    item.object = instance.info->id;
    item.key = primitive.key;
    item.world_from_local = deforms ? world : world * pose.model_from_node[static_cast<std::size_t>(node)];
    item.bounds = primitive.source->bounds;
    if (deforms) {
        item.deformation = static_cast<int>(deformations.size());
        deformations.push_back({.model = &asset, .pose = &pose, .node = node, .positions = {}, .normals = {}});
        // Tangents are not carried along; the shader derives a frame from the picture instead.
        item.key.has_tangent = false;
        if (source.skin >= 0 && primitive.source->targets.empty()) {
            item.bounds = skinned_bounds(asset, pose, node, primitive.joint_boxes);
        } else {
            const auto* made = reinterpret_cast<const glm::vec3*>(deformed(item, stream).positions.data);
            item.bounds = bounds_of({made, primitive.source->positions.size()});
        }
    }
    item.is_mirrored = glm::determinant(glm::dmat3(item.world_from_local)) < 0.0;

    if (item.key.lit) {
        const LightSet set = lights_around(lights, exposure, item.world_from_local, item.bounds);
        item.light_set = light_sets.add(set);
        item.key.directional_lights = set.directional;
        item.key.local_lights = set.local;
    } else {
        item.light_set = light_sets.add({});
    }
    items.push_back(item);
}

const Deformation& SceneItems::deformed(const SceneItem& item, StreamBuffer& stream) {
    Deformation& job = deformations[static_cast<std::size_t>(item.deformation)];
    if (job.is_done) return job;
    const Primitive& primitive = *item.primitive->source;
    const std::size_t count = primitive.positions.size();
    job.positions = stream.allocate(count * sizeof(glm::vec3));
    job.normals = stream.allocate(count * sizeof(glm::vec3));
    deform_vertices(*job.model, *job.pose, job.node, primitive,
                    {reinterpret_cast<glm::vec3*>(job.positions.data), count},
                    {reinterpret_cast<glm::vec3*>(job.normals.data), count});
    job.is_done = true;
    return job;
}

}  // namespace camrig
