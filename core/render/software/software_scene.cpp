#include "core/render/software/software_scene.h"

#include <bit>

namespace camrig {

const SoftwareModel& SoftwareModels::model(const ModelRef& source) {
    std::unique_ptr<SoftwareModel>& model = models_[source.get()];
    if (model == nullptr) model = make_software_model(source);
    return *model;
}

void SoftwareModels::evict_unused() {
    std::erase_if(models_, [](const auto& entry) { return entry.second->source.use_count() == 1; });
}

void SoftwareItems::clear() {
    items_.clear();
    deformations_used_ = poses_used_ = 0;
    has_only_triangles_ = true;
}

PosedModel& SoftwareItems::next_pose() {
    if (poses_used_ == poses_.size()) poses_.emplace_back();
    return poses_[poses_used_++];
}

DeformedVertices& SoftwareItems::next_deformation() {
    if (deformations_used_ == deformations_.size()) deformations_.emplace_back();
    return deformations_[deformations_used_++];
}

void SoftwareItems::add(const Instance& instance, SoftwareModels& models, std::span<const Light> lights,
                        float exposure) {
    const ModelRef& source = instance.info->model;
    if (source == nullptr) return;
    const SoftwareModel& model = models.model(source);
    has_only_triangles_ &= model.has_only_triangles;
    PosedModel& pose = next_pose();
    pose_model(*source, instance.clips, pose);
    for (const Surface& surface : model.surfaces) add_surface(instance, model, pose, surface, lights, exposure);
}

void SoftwareItems::add_surface(const Instance& instance, const SoftwareModel& model, const PosedModel& pose,
                                const Surface& surface, std::span<const Light> lights, float exposure) {
    const int node = surface.node;
    const Node& source = model.source->nodes[static_cast<std::size_t>(node)];
    const bool deforms = is_deformed(*model.source, node);
    const glm::dmat4 world = world_from_model(instance);
    const SoftwarePrimitive& primitive =
        model.meshes[static_cast<std::size_t>(source.mesh)][static_cast<std::size_t>(surface.primitive)];
    SoftwareItem& item = items_.emplace_back();
    item.model = &model;
    item.primitive = &primitive;
    item.world_from_local = deforms ? world : world * pose.model_from_node[static_cast<std::size_t>(node)];
    item.bounds = primitive.source->bounds;
    if (deforms) {
        item.deformation = static_cast<int>(deformations_used_);
        DeformedVertices& job = next_deformation();
        job.pose = &pose;
        job.node = node;
        job.made = 0;
        if (source.skin >= 0 && primitive.source->targets.empty()) {
            item.bounds = skinned_bounds(*model.source, pose, node, primitive.joint_boxes);
        } else {
            item.bounds = bounds_of(deform(item).positions);
        }
    }
    item.is_mirrored = glm::determinant(glm::dmat3(item.world_from_local)) < 0.0;
    if (primitive.is_lit) item.lights = lights_around(lights, exposure, item.world_from_local, item.bounds);
}

const DeformedVertices& SoftwareItems::deform(const SoftwareItem& item, LevelSet levels) {
    DeformedVertices& job = deformations_[static_cast<std::size_t>(item.deformation)];
    const LevelSet missing = job.missing(levels);
    const Primitive& primitive = *item.primitive->source;
    job.positions.resize(primitive.positions.size());
    job.normals.resize(primitive.positions.size());
    const auto make = [&](std::optional<std::span<const std::uint32_t>> which) {
        deform_vertices(*item.model->source, *job.pose, job.node, primitive, job.positions, job.normals, which);
    };
    if ((missing & 1) != 0) {
        make(std::nullopt);
    } else {
        for (LevelSet left = missing; left != 0; left &= left - 1)
            make(item.primitive->levels[static_cast<std::size_t>(std::countr_zero(left))].vertices);
    }
    job.made |= missing;
    return job;
}

const DeformedVertices& SoftwareItems::deformed(const SoftwareItem& item) const {
    return deformations_[static_cast<std::size_t>(item.deformation)];
}

std::uint64_t SoftwareItems::made() const {
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < deformations_used_; ++i) count += deformations_[i].made != 0;
    return count;
}

std::uint64_t SoftwareItems::unseen() const {
    return deformations_used_ - made();
}

}  // namespace camrig
