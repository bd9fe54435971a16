#include "core/truth/posed_object.h"

#include <limits>

namespace camrig::truth {

void PosedObject::pose(const world::Instance& instance) {
    part_count_ = 0;
    min_ = glm::dvec3(std::numeric_limits<double>::infinity());
    max_ = -min_;
    info_ = instance.info;
    model_ = info_->model;
    position_ = instance.position;
    const glm::dquat& heading = instance.info->heading_from_model;
    orientation_ = glm::normalize(instance.orientation * glm::conjugate(heading));
    object_from_model_ = glm::mat3_cast(heading) * instance.scale;
    if (model_) pose_model(*model_, instance.clips, pose_);
}

template <typename Visit>
void PosedObject::for_each_surface(Visit&& visit) const {
    if (!model_) return;
    for (const int node : model_->order) {
        const int mesh = model_->nodes[static_cast<std::size_t>(node)].mesh;
        if (mesh < 0) continue;
        for (const world::Primitive& primitive : model_->meshes[static_cast<std::size_t>(mesh)].primitives) {
            const bool is_blended =
                primitive.material >= 0 &&
                model_->materials[static_cast<std::size_t>(primitive.material)].alpha_mode == world::AlphaMode::blend;
            if (!is_blended && !world::look_of(info_->look, primitive.material).is_hidden) visit(primitive, node);
        }
    }
}

std::optional<PosedObject::Ball> PosedObject::reach() const {
    const glm::dmat4 object_from_model(object_from_model_);
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    bool is_known = true;
    const auto grow = [&](const glm::dmat4& m, const world::Box& box) {
        const glm::dvec3 middle(m * glm::dvec4(0.5 * (glm::dvec3(box.min) + glm::dvec3(box.max)), 1.0));
        const glm::dvec3 half = 0.5 * (glm::dvec3(box.max) - glm::dvec3(box.min));
        const glm::dvec3 extent = glm::abs(glm::dvec3(m[0])) * half.x + glm::abs(glm::dvec3(m[1])) * half.y +
                                  glm::abs(glm::dvec3(m[2])) * half.z;
        low = glm::min(low, middle - extent);
        high = glm::max(high, middle + extent);
    };
    for_each_surface([&](const world::Primitive& primitive, int node) {
        const int skin = model_->nodes[static_cast<std::size_t>(node)].skin;
        is_known &= primitive.targets.empty();
        if (skin < 0 || primitive.joints.empty()) {
            grow(object_from_model * pose_.model_from_node[static_cast<std::size_t>(node)], primitive.bounds);
            return;
        }
        // A skinned vertex is a weighted mean of where its joints carry it.
        const world::Skin& bones = model_->skins[static_cast<std::size_t>(skin)];
        for (std::size_t j = 0; j < bones.joints.size(); ++j) {
            const auto joint = static_cast<std::size_t>(bones.joints[j]);
            grow(object_from_model * pose_.model_from_node[joint] * bones.inverse_bind[j], primitive.bounds);
        }
    });
    if (!is_known) return std::nullopt;
    if (!(low.x <= high.x)) return Ball{};
    return Ball{0.5 * (low + high), 0.5 * glm::length(high - low)};
}

void PosedObject::place_vertices() {
    for_each_surface([this](const world::Primitive& primitive, int node) { add_part(primitive, node); });
}

void PosedObject::add_part(const world::Primitive& primitive, int node) {
    const world::Model& model = *model_;
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

}  // namespace camrig::truth
