#include "core/render/gl/scene_items.h"

#include <algorithm>

namespace camrig {
namespace {

glm::dmat4 world_from_model(const Instance& instance) {
    glm::dmat4 result(glm::mat3_cast(instance.orientation) * instance.scale);
    result[3] = glm::dvec4(instance.position, 1.0);
    return result;
}

Box bounds_of(std::span<const glm::vec3> points) {
    Box box{points.front(), points.front()};
    for (const glm::vec3& point : points) {
        box.min = glm::min(box.min, point);
        box.max = glm::max(box.max, point);
    }
    return box;
}

glm::vec3 extent_along(const glm::dmat4& m, glm::dvec3 half) {
    return glm::vec3(glm::abs(glm::dvec3(m[0])) * half.x + glm::abs(glm::dvec3(m[1])) * half.y +
                     glm::abs(glm::dvec3(m[2])) * half.z);
}

void grow(Box& box, bool& is_empty, const glm::dmat4& m, const Box& local) {
    const glm::vec3 centre(m * glm::dvec4(0.5 * (glm::dvec3(local.min) + glm::dvec3(local.max)), 1.0));
    const glm::vec3 half = extent_along(m, 0.5 * (glm::dvec3(local.max) - glm::dvec3(local.min)));
    box.min = is_empty ? centre - half : glm::min(box.min, centre - half);
    box.max = is_empty ? centre + half : glm::max(box.max, centre + half);
    is_empty = false;
}

/// Bounds of a skinned primitive without skinning it: a skinned vertex is a weighted mean of where its joints carry
/// it, so it lies in the hull of the boxes of each joint's own vertices, carried by that joint.
Box skinned_bounds(const Model& model, const PosedModel& pose, int node, const GpuPrimitive& primitive) {
    const Skin& skin = model.skins[static_cast<std::size_t>(model.nodes[static_cast<std::size_t>(node)].skin)];
    Box box;
    bool is_empty = true;
    for (std::size_t j = 0; j < primitive.joint_boxes.size(); ++j) {
        const auto& reach = primitive.joint_boxes[j];
        if (!reach.is_used) continue;
        const auto joint = static_cast<std::size_t>(skin.joints[j]);
        grow(box, is_empty, pose.model_from_node[joint] * skin.inverse_bind[j], reach.box);
    }
    return box;
}

}  // namespace

int LightTable::add(const LightSet& set) {
    const auto found = std::ranges::find(sets_, set);
    if (found != sets_.end()) return static_cast<int>(found - sets_.begin());
    sets_.push_back(set);
    return size() - 1;
}

const GpuModel& ModelCache::model(const ModelRef& model) {
    const auto found = models_.find(model.get());
    if (found != models_.end()) return found->second;
    return models_.emplace(model.get(), upload_model(gl_, samplers_, model)).first->second;
}

void ModelCache::evict_unused() {
    std::erase_if(models_, [](const auto& entry) { return entry.second.source.use_count() == 1; });
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
    for (const int node : source->order) {
        if (source->nodes[static_cast<std::size_t>(node)].mesh < 0) continue;
        add_node(instance, model, pose, node, light_sets, lights, exposure, stream);
    }
}

void SceneItems::add_node(const Instance& instance, const GpuModel& model, const PosedModel& pose, int node,
                          LightTable& light_sets, std::span<const Light> lights, float exposure, StreamBuffer& stream) {
    const Node& source = model.source->nodes[static_cast<std::size_t>(node)];
    const bool deforms = is_deformed(*model.source, node);
    const glm::dmat4 world = world_from_model(instance);
    for (const GpuPrimitive& primitive : model.meshes[static_cast<std::size_t>(source.mesh)]) {
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
            deformations.push_back({.pose = &pose, .node = node, .positions = {}, .normals = {}});
            // Tangents are not carried along; the shader derives a frame from the picture instead.
            item.key.has_tangent = false;
            if (source.skin >= 0 && primitive.source->targets.empty()) {
                item.bounds = skinned_bounds(*model.source, pose, node, primitive);
            } else {
                const auto* made = reinterpret_cast<const glm::vec3*>(deformed(item, stream).positions.data);
                item.bounds = bounds_of({made, primitive.source->positions.size()});
            }
        }
        item.is_mirrored = glm::determinant(glm::dmat3(item.world_from_local)) < 0.0;

        const glm::dvec3 half = 0.5 * (glm::dvec3(item.bounds.max) - glm::dvec3(item.bounds.min));
        const glm::dvec3 centre = 0.5 * (glm::dvec3(item.bounds.max) + glm::dvec3(item.bounds.min));
        if (item.key.lit) {
            const LightSet set =
                select_lights(lights, exposure, glm::dvec3(item.world_from_local * glm::dvec4(centre, 1.0)),
                              glm::length(extent_along(item.world_from_local, half)));
            item.light_set = light_sets.add(set);
            item.key.directional_lights = set.directional;
            item.key.local_lights = set.local;
        } else {
            item.light_set = light_sets.add({});
        }
        items.push_back(item);
    }
}

const Deformation& SceneItems::deformed(const SceneItem& item, StreamBuffer& stream) {
    Deformation& job = deformations[static_cast<std::size_t>(item.deformation)];
    if (job.is_done) return job;
    const Primitive& primitive = *item.primitive->source;
    const std::size_t count = primitive.positions.size();
    job.positions = stream.allocate(count * sizeof(glm::vec3));
    job.normals = stream.allocate(count * sizeof(glm::vec3));
    deform_vertices(*item.model->source, *job.pose, job.node, primitive,
                    {reinterpret_cast<glm::vec3*>(job.positions.data), count},
                    {reinterpret_cast<glm::vec3*>(job.normals.data), count});
    job.is_done = true;
    return job;
}

}  // namespace camrig
