#include "core/render/scene/placed_scene.h"

#include <algorithm>
#include <bit>
#include <string_view>

#include "core/world/model_lights.h"

namespace camrig::render::scene {
namespace {

bool same_objects(const world::StaticSet& a, const world::StaticSet& b) {
    return std::ranges::equal(a.objects, b.objects, [](const world::Instance& x, const world::Instance& y) {
        return x.info == y.info && x.position == y.position && x.orientation == y.orientation && x.scale == y.scale &&
               x.clips.empty() && y.clips.empty();
    });
}

bool stands_as_then(const world::Instance& object, const world::BakedObject& then) {
    return object.info->model_name == then.model && object.position == then.position &&
           object.orientation == then.orientation && object.scale == then.scale;
}

}  // namespace

int LightTable::add(const LightSet& set) {
    const auto found = std::ranges::find(sets_, set);
    if (found != sets_.end()) return static_cast<int>(found - sets_.begin());
    sets_.push_back(set);
    return size() - 1;
}

void PlacedSurfaces::clear() {
    surfaces_.clear();
    blended_.clear();
    bodies_.clear();
    deformations_used_ = poses_used_ = 0;
}

world::PosedModel& PlacedSurfaces::next_pose() {
    if (poses_used_ == poses_.size()) poses_.emplace_back();
    return poses_[poses_used_++];
}

DeformedVertices& PlacedSurfaces::next_deformation() {
    if (deformations_used_ == deformations_.size()) deformations_.emplace_back();
    return deformations_[deformations_used_++];
}

void PlacedSurfaces::add(const world::Instance& instance, PreparedModels& models, LightTable& light_sets,
                         std::span<const world::Light> lights, float exposure) {
    const world::ModelRef& source = instance.info->model;
    if (source == nullptr) return;
    const PreparedModel& model = models.of(source, prepare_model);
    world::PosedModel& pose = next_pose();
    pose_model(*source, instance.clips, pose);
    const glm::dmat4 world = world::world_from_model(instance.position, instance.orientation, instance.scale);
    bodies_.add(instance.info->id, model.body, pose, world);
    contacts_.begin();
    for (const PreparedSurface& prepared : model.surfaces) {
        const PreparedPrimitive& primitive = *prepared.primitive;
        const world::MaterialLook look = world::look_of(instance.info->look, primitive.source->material);
        if (look.is_hidden) continue;
        PlacedSurface& surface = place(primitive, model, source, *instance.info);
        surface.tint = look.tint;
        surface.node = prepared.node;
        surface.world_from_local =
            prepared.is_deformed ? world : world * pose.model_from_node[static_cast<std::size_t>(prepared.node)];
        surface.bounds = primitive.source->bounds;
        if (prepared.is_deformed) {
            surface.deformation = static_cast<int>(deformations_used_);
            DeformedVertices& job = next_deformation();
            job.pose = &pose;
            job.node = prepared.node;
            job.made = 0;
            const auto note = [&](int joint, const world::Box& box) { contacts_.add(joint, box); };
            surface.bounds = prepared.is_skinned
                                 ? skinned_bounds(*source, pose, prepared.node, primitive.joint_boxes, note)
                                 : bounds_of(deform(surface).positions);
        }
        surface.is_mirrored = glm::determinant(glm::dmat3(surface.world_from_local)) < 0.0;
        surface.turns_clockwise =
            surface.is_mirrored !=
            (prepared.is_deformed && world::deforming_mirrors(*source, pose, prepared.node, *primitive.source));
        surface.light_set = light_sets.add(
            primitive.is_lit ? lights_around(lights, exposure, surface.world_from_local, surface.bounds) : LightSet{});
    }
    const std::span<const ContactShadow> contacts = contacts_.find();
    if (contacts.empty()) return;
    const PreparedModel& patches = models.of(contact_model(), prepare_model);
    for (const ContactShadow& contact : contacts) {
        const PreparedPrimitive& primitive = patches.primitives[static_cast<std::size_t>(contact.shade)];
        PlacedSurface& surface = place(primitive, patches, contact_model(), *instance.info);
        surface.world_from_local = world * contact.model_from_patch;
        surface.bounds = primitive.source->bounds;
        surface.light_set = light_sets.add({});
        surface.is_contact_shadow = true;
    }
}

void PlacedSurfaces::find_baked(std::size_t first, const world::BakedObject& object) {
    for (PlacedSurface& surface : std::span(surfaces_).subspan(first)) {
        const world::BakedSurface wanted{.node = surface.node, .primitive = surface.primitive->number};
        const auto baked = std::ranges::lower_bound(object.surfaces, wanted, world::is_before);
        if (baked != object.surfaces.end() && !world::is_before(wanted, *baked) &&
            !surface.primitive->source->light_coordinates.empty())
            surface.light_map_at = {baked->x, baked->y};
    }
}

void PlacedSurfaces::light_anew(LightTable& light_sets, std::span<const world::Light> lights, float exposure) {
    for (PlacedSurface& surface : surfaces_)
        surface.light_set = light_sets.add(
            surface.primitive->is_lit ? lights_around(lights, exposure, surface.world_from_local, surface.bounds)
                                      : LightSet{});
}

PlacedSurface& PlacedSurfaces::place(const PreparedPrimitive& primitive, const PreparedModel& model,
                                     const world::ModelRef& source, const world::ObjectInfo& object) {
    PlacedSurface& surface = surfaces_.emplace_back();
    surface.object = &object;
    surface.source = &source;
    surface.model = &model;
    surface.primitive = &primitive;
    surface.index = surfaces_.size() - 1;
    if (primitive.is_blended) blended_.push_back(surface.index);
    return surface;
}

const DeformedVertices& PlacedSurfaces::deform(const PlacedSurface& surface, LevelSet levels) {
    DeformedVertices& job = deformations_[static_cast<std::size_t>(surface.deformation)];
    const LevelSet missing = job.missing(levels);
    const world::Primitive& primitive = *surface.primitive->source;
    job.positions.resize(primitive.positions.size());
    job.normals.resize(primitive.positions.size());
    const auto make = [&](std::optional<std::span<const std::uint32_t>> which) {
        deform_vertices(**surface.source, *job.pose, job.node, primitive, job.positions, job.normals, which);
    };
    if ((missing & 1) != 0) {
        make(std::nullopt);
    } else {
        for (LevelSet left = missing; left != 0; left &= left - 1)
            make(surface.primitive->coarser[static_cast<std::size_t>(std::countr_zero(left)) - 1].vertices);
    }
    job.made |= missing;
    return job;
}

const DeformedVertices& PlacedSurfaces::deformed(const PlacedSurface& surface) const {
    return deformations_[static_cast<std::size_t>(surface.deformation)];
}

std::uint64_t PlacedSurfaces::made() const {
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < deformations_used_; ++i) count += deformations_[i].made != 0;
    return count;
}

void PlacedScene::place(const world::SnapshotRef& snapshot) {
    meshes_made_ = meshes_made();
    meshes_unseen_ = meshes_unseen();
    // What is placed points into the snapshot, and into models that live as long as it holds them.
    movers_.clear();
    place_statics(snapshot->statics);
    keep_proxies();
    snapshot_ = snapshot;
    light_sets_.truncate(static_light_sets_);
    for (const world::Instance& mover : snapshot->movers)
        movers_.add(mover, *models_, light_sets_, lights(), environment().exposure);
    models_->evict_unused();
}

void PlacedScene::place_statics(const std::shared_ptr<const world::StaticSet>& statics) {
    // By identity: two worlds may have equal ones.
    if (statics == static_set_) return;
    objects_number_ += static_set_ == nullptr || !same_objects(*static_set_, *statics);
    ++statics_number_;
    statics_.clear();
    light_sets_.truncate(0);
    static_set_ = statics;
    std::map<std::string_view, const world::BakedObject*> baked;
    if (statics->baked_light != nullptr)
        for (const world::BakedObject& object : statics->baked_light->objects) baked[object.name] = &object;
    for (const world::Instance& object : statics->objects) {
        const std::size_t first = statics_.all().size();
        statics_.add(object, *models_, light_sets_, lights(), environment().exposure);
        const auto found = baked.find(object.info->name);
        if (found != baked.end() && stands_as_then(object, *found->second)) statics_.find_baked(first, *found->second);
    }
    for (const PlacedSurface& surface : statics_.all())
        if (surface.deformation >= 0) statics_.deform(surface);
    own_light_sets_ = static_light_sets_ = light_sets_.size();
    has_new_statics_ = true;
}

const PlacedSurfaces* PlacedScene::proxies_of(const std::shared_ptr<const world::Backdrop>& backdrop) {
    if (backdrop == nullptr || (backdrop->proxies.empty() && backdrop->catchers.empty())) return nullptr;
    Proxies& kept = proxies_[backdrop.get()];
    if (kept.of.lock() == backdrop) return &kept.placed;
    kept.of = backdrop;
    kept.placed.clear();
    for (const auto& shapes : {std::span(backdrop->catchers), std::span(backdrop->proxies)})
        for (const world::Instance& proxy : shapes)
            kept.placed.add(proxy, *models_, light_sets_, lights(), environment().exposure);
    for (const PlacedSurface& surface : kept.placed.all())
        if (surface.deformation >= 0) kept.placed.deform(surface);
    ++proxies_number_;
    has_new_proxies_ = true;
    return &kept.placed;
}

void PlacedScene::keep_proxies() {
    const std::size_t gone = std::erase_if(proxies_, [](const auto& one) { return one.second.of.expired(); });
    if (gone > 0) ++proxies_number_;
    if (!has_new_proxies_ && !has_new_statics_ && gone == 0) return;
    has_new_proxies_ = has_new_statics_ = false;
    light_sets_.truncate(own_light_sets_);
    for (auto& [key, one] : proxies_) one.placed.light_anew(light_sets_, lights(), environment().exposure);
    static_light_sets_ = light_sets_.size();
}

void PlacedScene::clear() {
    meshes_made_ = meshes_made();
    meshes_unseen_ = meshes_unseen();
    movers_.clear();
    statics_.clear();
    light_sets_.truncate(0);
    static_light_sets_ = own_light_sets_ = 0;
    proxies_.clear();
    ++proxies_number_;
    snapshot_.reset();
    static_set_.reset();
}

}  // namespace camrig::render::scene
