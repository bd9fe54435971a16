#include "core/truth/posed_object.h"

#include <limits>

namespace camrig {

void PosedObject::pose(const Instance& instance) {
    part_count_ = 0;
    min_ = glm::dvec3(std::numeric_limits<double>::infinity());
    max_ = -min_;
    position_ = instance.position;
    const glm::dquat& heading = instance.info->heading_from_model;
    orientation_ = glm::normalize(instance.orientation * glm::conjugate(heading));
    object_from_model_ = glm::mat3_cast(heading) * instance.scale;
    if (!instance.info->model) return;
    const Model& model = *instance.info->model;
    pose_model(model, instance.clips, pose_);
    for (const int node : model.order) {
        const int mesh = model.nodes[static_cast<std::size_t>(node)].mesh;
        if (mesh < 0) continue;
        for (const Primitive& primitive : model.meshes[static_cast<std::size_t>(mesh)].primitives) {
            const bool is_blended =
                primitive.material >= 0 &&
                model.materials[static_cast<std::size_t>(primitive.material)].alpha_mode == AlphaMode::blend;
            if (!is_blended) add_part(primitive, model, node);
        }
    }
}

void PosedObject::add_part(const Primitive& primitive, const Model& model, int node) {
    if (part_count_ == parts_.size()) parts_.emplace_back();
    Part& part = parts_[part_count_];
    part.primitive = &primitive;
    part.points.clear();
    if (is_deformed(model, node)) {
        positions_.resize(primitive.positions.size());
        normals_.resize(primitive.positions.size());
        deform_vertices(model, pose_, node, primitive, positions_, normals_);
        for (const glm::vec3& p : positions_) part.points.push_back(object_from_model_ * glm::dvec3(p));
    } else {
        const glm::dmat4 object_from_node =
            glm::dmat4(object_from_model_) * pose_.model_from_node[static_cast<std::size_t>(node)];
        for (const glm::vec3& p : primitive.positions)
            part.points.emplace_back(object_from_node * glm::dvec4(glm::dvec3(p), 1.0));
    }
    // Vertices that no index names are no surface.
    for (const std::uint32_t index : primitive.indices) {
        min_ = glm::min(min_, part.points[index]);
        max_ = glm::max(max_, part.points[index]);
    }
    ++part_count_;
}

glm::dvec3 PosedObject::place_of_node(std::size_t node) const {
    return object_from_model_ * glm::dvec3(pose_.model_from_node[node][3]);
}

}  // namespace camrig
