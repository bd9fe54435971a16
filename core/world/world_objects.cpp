#include <algorithm>

#include "core/world/scene_reader.h"
#include "core/world/scene_world.h"

// What commands do to objects that stand where they are, and what actors and objects have in common.
namespace camrig::world {
namespace {

/// Kept in the order of their ids, so that who was hidden and is shown again is drawn as before.
void insert(std::vector<Instance>& objects, Instance object) {
    const auto at = std::ranges::find_if(objects, [&](const Instance& one) { return one.info->id > object.info->id; });
    objects.insert(at, std::move(object));
}

Error no_object(const std::string& name) {
    return {ErrorKind::not_found, "name: there is no object '" + name.substr(0, 80) + "'; object.list lists them"};
}

bool finds_its_way(const BehaviourSpec& behaviour) {
    return std::visit([](const auto& kind) { return requires { kind.walk; }; }, behaviour);
}

}  // namespace

std::size_t SceneWorld::object_count() const {
    return statics_->objects.size() + statics_->hidden.size() +
           static_cast<std::size_t>(
               std::ranges::count_if(movers_, [](const auto& mover) { return !mover->is_actor && !mover->is_gone; }));
}

Result<void> SceneWorld::spawn_object(const ObjectSpec& spec) {
    thread_.check();
    const KnownNames names = known_names();
    if (names.actors.contains(spec.name) || names.objects.contains(spec.name))
        return error(ErrorKind::already_exists, "name: '" + spec.name + "' is taken by another object or actor");
    if (object_count() >= max_scene_objects)
        return error(ErrorKind::resource_exhausted, "a world has at most 20000 objects; remove one");
    if (!spec.clip.empty() && by_name_.size() >= max_world_actors)
        return error(ErrorKind::resource_exhausted, "a world has at most 5000 that move; remove one");
    if (auto good = check_object(spec, names, ""); !good) return good;
    is_current_ = false;
    add_object(spec, edit_statics());
    return {};
}

Result<void> SceneWorld::change_object(const ObjectPatch& patch) {
    thread_.check();
    if (Mover* const mover = find(patch.name)) return change_mover(*mover, patch);
    const auto is_it = [&](const Instance& one) { return one.info->name == patch.name; };
    const bool was_hidden = std::ranges::none_of(statics_->objects, is_it);
    if (was_hidden && std::ranges::none_of(statics_->hidden, is_it)) return std::unexpected(no_object(patch.name));
    is_current_ = false;
    StaticSet& statics = edit_statics();
    auto& from = was_hidden ? statics.hidden : statics.objects;
    const auto at = std::ranges::find_if(from, is_it);
    at->position = patch.position.value_or(at->position);
    at->orientation = patch.orientation.value_or(at->orientation);
    at->scale = patch.scale.value_or(at->scale);
    if (patch.hidden.value_or(was_hidden) == was_hidden) return {};
    Instance moved = std::move(*at);
    from.erase(at);
    insert(was_hidden ? statics.objects : statics.hidden, std::move(moved));
    return {};
}

Result<void> SceneWorld::change_mover(Mover& mover, const ObjectPatch& patch) {
    if (mover.is_actor && (patch.position || patch.orientation))
        return error(ErrorKind::invalid_argument, std::string(patch.position ? "position" : "orientation") + ": '" +
                                                      patch.name + "' is an actor; actor.set and actor.steer place it");
    if (mover.held && (patch.position || patch.orientation))
        return error(ErrorKind::invalid_argument, std::string(patch.position ? "position" : "orientation") + ": '" +
                                                      patch.name + "' hangs on " + mover.held->carrier_name);
    is_current_ = false;
    mover.is_hidden = patch.hidden.value_or(mover.is_hidden);
    if (patch.position || patch.orientation)
        mover.jump([&](ActorState& now) {
            now.position = patch.position.value_or(now.position);
            now.orientation = patch.orientation.value_or(now.orientation);
        });
    if (patch.scale && *patch.scale != mover.scale) {
        mover.radius_m *= *patch.scale / mover.scale;
        mover.scale = *patch.scale;
        // The ways on which a body so large can walk are others.
        if (mover.is_actor && finds_its_way(mover.spec)) behave(mover, BehaviourSpec(mover.spec));
    }
    return {};
}

Result<void> SceneWorld::remove_object(const std::string& name) {
    thread_.check();
    if (Mover* const mover = find(name)) {
        if (mover->is_actor)
            return error(ErrorKind::invalid_argument, "name: '" + name + "' is an actor; actor.remove removes it");
        is_current_ = false;
        remove(*mover);
        return {};
    }
    const auto is_it = [&](const Instance& one) { return one.info->name == name; };
    if (std::ranges::none_of(statics_->objects, is_it) && std::ranges::none_of(statics_->hidden, is_it))
        return std::unexpected(no_object(name));
    is_current_ = false;
    StaticSet& statics = edit_statics();
    std::erase_if(statics.objects, is_it);
    std::erase_if(statics.hidden, is_it);
    return {};
}

}  // namespace camrig::world
