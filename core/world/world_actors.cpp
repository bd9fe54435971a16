#include <algorithm>
#include <cmath>

#include "core/world/behaviour/stand_behaviour.h"
#include "core/world/behaviour/steered.h"
#include "core/world/read/check_walkable.h"
#include "core/world/scene_world.h"
#include "core/world/turn.h"

// What commands and events do to actors. Everything is checked before anything changes.
namespace camrig::world {
namespace {

constexpr std::ptrdiff_t max_departures = 4096;

}  // namespace

Mover* SceneWorld::find(const std::string& name) const {
    const auto found = by_name_.find(name);
    return found == by_name_.end() ? nullptr : found->second;
}

Result<Mover*> SceneWorld::need_actor(const std::string& name) const {
    Mover* mover = find(name);
    if (mover && mover->is_actor) return mover;
    return error(ErrorKind::not_found, "name: there is no actor '" + name.substr(0, 80) + "'; actor.list lists them");
}

KnownNames SceneWorld::known_names() const {
    KnownNames names{.scene = *scene_, .actors = {}, .spawned = {}, .objects = {}, .events = {}};
    for (const auto& [name, mover] : by_name_) {
        if (mover->is_actor)
            names.actors.emplace(name, mover->model);
        else
            names.objects.insert(name);
    }
    for (const auto* objects : {&statics_->objects, &statics_->hidden})
        for (const Instance& object : *objects) names.objects.insert(object.info->name);
    for (const EventReport& event : events_.reports()) names.events.insert(event.name);
    return names;
}

FollowGraph SceneWorld::follows(const std::string& without) const {
    FollowGraph graph;
    for (const auto& [name, mover] : by_name_)
        if (name != without) graph.add(name, mover->spec);
    return graph;
}

ActorReport SceneWorld::report(const Mover& mover) const {
    ActorReport report;
    report.id = mover.id();
    report.name = mover.info->name;
    report.object_class = mover.info->object_class;
    report.model = mover.model;
    report.scale = mover.scale;
    report.variant = mover.variant;
    report.position = mover.now.position;
    report.orientation = mover.now.orientation;
    report.velocity = mover.velocity(scene_->step_ns);
    report.behaviour = type_name(mover.spec);
    report.arrived = mover.behaviour->arrived();
    const auto clip = std::ranges::max_element(mover.now.clips, {}, &ClipPlay::weight);
    if (clip != mover.now.clips.end())
        report.clip = mover.info->model->animations[static_cast<std::size_t>(clip->animation)].name;
    if (mover.held) {
        report.attached_to = mover.held->carrier_name;
        if (const Mover* carrier = find(mover.held->carrier_name)) report.position = hanging(mover, *carrier).position;
    }
    return report;
}

std::vector<ActorReport> SceneWorld::actors() const {
    thread_.check();
    std::vector<ActorReport> all;
    for (const auto& mover : movers_)
        if (mover->is_actor && !mover->is_gone) all.push_back(report(*mover));
    return all;
}

Result<ActorReport> SceneWorld::spawn_actor(const ActorSpec& spec) {
    thread_.check();
    is_current_ = false;
    KnownNames names = known_names();
    if (names.actors.contains(spec.name) || names.objects.contains(spec.name))
        return error(ErrorKind::already_exists, "name: '" + spec.name + "' is taken by another object or actor");
    if (by_name_.size() >= max_world_actors)
        return error(ErrorKind::resource_exhausted, "a world has at most 5000 actors; remove one");
    if (auto good = check_actor(spec, names, ""); !good) return std::unexpected(good.error());
    FollowGraph graph = follows(spec.name);
    graph.add(spec.name, spec.behaviour);
    if (auto good = check_follows(spec.name, graph, ""); !good) return std::unexpected(good.error());
    if (spec.attach)
        if (auto good = check_carrier(spec.name, *spec.attach, "attach."); !good) return std::unexpected(good.error());
    Mover& mover = add_actor(spec);
    if (spec.attach) attach(mover, *spec.attach);
    return report(mover);
}

void SceneWorld::remove(Mover& mover) {
    const std::uint32_t id = mover.id();
    for (const auto& other : movers_)
        if (other->held && other->held->carrier == id) put_down(*other, std::nullopt);
    const Mover* carrier = mover.held ? find(mover.held->carrier_name) : nullptr;
    if (departures_.size() >= max_departures)
        departures_.erase(departures_.begin(), departures_.begin() + max_departures / 2);
    departures_.push_back({now_ns_, carrier ? hanging(mover, *carrier) : instance_of(mover.record(scene_->step_ns))});
    mover.held.reset();
    mover.is_gone = true;
    by_name_.erase(mover.info->name);
}

Result<void> SceneWorld::remove_actor(const std::string& name) {
    thread_.check();
    is_current_ = false;
    const auto mover = need_actor(name);
    if (!mover) return std::unexpected(mover.error());
    remove(**mover);
    return {};
}

void SceneWorld::behave(Mover& mover, const BehaviourSpec& spec) {
    mover.spec = spec;
    mover.behaviour = factory_.make(spec, {.model = mover.info->model, .radius_m = mover.radius_m}, true);
    mover.held_at_ns.reset();
    StepContext own = context();
    own.id = mover.id();
    own.radius_m = mover.radius_m;
    own.scale = mover.scale;
    own.now_ns = now_ns_ - mover.behind_ns;
    const std::vector<ClipPlay> clips = mover.now.clips;
    ActorState begun = mover.now;
    mover.behaviour->start(own, begun);
    // Most begin where the actor is.
    if (begun.position != mover.now.position || begun.orientation != mover.now.orientation)
        mover.jump([&](ActorState& now) { now = begun; });
    mover.now.clips = clips;  // the next step fades to the new one
    mover.take_clip(begun);
    mover.was_arrived = mover.behaviour->arrived();
}

Result<void> SceneWorld::check_behave(const Mover& mover, const BehaviourSpec& spec, const std::string& path) const {
    const std::string& name = mover.info->name;
    if (auto good = check_behaviour(spec, *mover.info->model, known_names(), path + "behaviour"); !good) return good;
    FollowGraph graph = follows(name);
    graph.add(name, spec);
    return check_follows(name, graph, path.empty() ? "" : path.substr(0, path.size() - 1));
}

Result<void> SceneWorld::check_place(const Mover& mover, const glm::dvec3& place, const std::string& path) const {
    if (mover.info->object_class != person_class) return {};
    const auto why = why_unwalkable(*scene_, place);
    return why ? error(ErrorKind::invalid_argument, path + ": " + *why) : Result<void>();
}

Result<void> SceneWorld::check_mount(const Mount& mount, const std::string& path) const {
    thread_.check();
    return world::check_mount(mount, known_names(), path);
}

Result<void> SceneWorld::check_carrier(const std::string& name, const Attachment& to, const std::string& path) const {
    const Mover* carrier = find(to.actor);
    if (!carrier || carrier->held || to.actor == name)
        return error(ErrorKind::invalid_argument, path + "actor: '" + to.actor +
                                                      "' hangs on something itself, or is not there; name an actor "
                                                      "that stands on its own");
    const Mover* mover = find(name);
    for (const auto& other : movers_)
        if (mover && other->held && other->held->carrier == mover->id())
            return error(ErrorKind::invalid_argument, path + "actor: '" + name + "' carries something itself");
    return {};
}

void SceneWorld::attach(Mover& mover, const Attachment& to) {
    const Mover& carrier = *find(to.actor);
    const auto& nodes = carrier.info->model->nodes;
    const auto node = std::ranges::find(nodes, to.node, &Node::name);
    mover.held = Held{.carrier = carrier.id(),
                      .node = to.node.empty() ? -1 : static_cast<int>(node - nodes.begin()),
                      .heading_from_model = carrier.heading_from_model,
                      .position = to.position,
                      .orientation = to.orientation,
                      .carrier_name = to.actor};
}

void SceneWorld::put_down(Mover& mover, const std::optional<glm::dvec3>& position) {
    const Mover* carrier = find(mover.held->carrier_name);
    glm::dvec3 place = position.value_or(mover.now.position);
    double yaw = 0.0;
    if (carrier) {
        const Instance there = hanging(mover, *carrier);
        yaw = yaw_of(there.orientation);
        if (!position) place = {there.position.x, there.position.y, carrier->now.position.z};
    }
    mover.held.reset();
    mover.jump([&](ActorState& now) {
        now.position = place;
        now.orientation = turned_to(yaw) * glm::inverse(mover.heading_from_model);
    });
    // A route says where its actor is at any time: it goes there from where it was put, and does not fly.
    if (mover.is_actor && places_actor(mover.spec)) behave(mover, BehaviourSpec(mover.spec));
}

Mover* SceneWorld::as_mover(const std::string& object) {
    if (Mover* mover = find(object)) return mover;
    StaticSet& statics = edit_statics();
    const auto is_it = [&](const Instance& one) { return one.info->name == object; };
    const bool is_hidden = std::ranges::none_of(statics.objects, is_it);
    auto& objects = is_hidden ? statics.hidden : statics.objects;
    const auto found = std::ranges::find_if(objects, is_it);
    if (found == objects.end()) return nullptr;
    auto mover = std::make_unique<Mover>();
    mover->info = found->info;
    mover->scale = found->scale;
    mover->now.position = found->position;
    mover->now.orientation = found->orientation;
    mover->behaviour = std::make_unique<Standing>(found->info->model, -1);
    mover->is_hidden = is_hidden;
    objects.erase(found);
    return &add_mover(std::move(mover));
}

void SceneWorld::wear(Mover& mover, std::optional<std::uint64_t> variant) {
    auto info = std::make_shared<ObjectInfo>(*mover.info);
    info->look = look_of(*info->model, variant);
    mover.variant = variant;
    mover.info = std::move(info);
}

Result<ActorReport> SceneWorld::change_actor(const ActorPatch& patch) {
    thread_.check();
    is_current_ = false;
    const auto found = need_actor(patch.name);
    if (!found) return std::unexpected(found.error());
    Mover& mover = **found;
    if (patch.behaviour)
        if (auto good = check_behave(mover, *patch.behaviour, ""); !good) return std::unexpected(good.error());
    if (patch.behaviour && (patch.position || patch.orientation) && places_actor(*patch.behaviour) &&
        std::holds_alternative<VehicleBehaviour>(*patch.behaviour))
        return error(ErrorKind::invalid_argument, "position: its route places this actor");
    if (patch.position && !patch.attach)
        if (auto good = check_place(mover, *patch.position, "position"); !good) return std::unexpected(good.error());
    if (patch.play)
        if (auto good = check_clip(*mover.info->model, *patch.play, "play"); !good)
            return std::unexpected(good.error());
    if (patch.attach) {
        if (auto good = check_attachment(*patch.attach, known_names(), "attach"); !good)
            return std::unexpected(good.error());
        if (auto good = check_carrier(patch.name, *patch.attach, "attach."); !good)
            return std::unexpected(good.error());
    }
    if (patch.detach && !mover.held)
        return error(ErrorKind::invalid_argument, "detach: '" + patch.name + "' hangs on nothing");

    if (patch.variant) wear(mover, patch.variant);
    if (patch.detach) put_down(mover, patch.position);
    if (patch.position || patch.orientation)
        mover.jump([&](ActorState& now) {
            now.position = patch.position.value_or(now.position);
            now.orientation = patch.orientation.value_or(now.orientation);
        });
    // Who was put somewhere else does there what it did, from the beginning.
    if (patch.behaviour)
        behave(mover, *patch.behaviour);
    else if (patch.position || patch.orientation)
        behave(mover, BehaviourSpec(mover.spec));
    if (patch.attach) attach(mover, *patch.attach);
    if (patch.play) {
        mover.played.reset();
        if (!patch.play->empty())
            mover.played = Mover::Played{.animation = mover.info->model->find_animation(*patch.play),
                                         .speed_ppm = std::llround(patch.play_speed * 1e6),
                                         .began_ns = now_ns_,
                                         .until_ns = {}};
    }
    return report(mover);
}

Result<void> SceneWorld::steer_actors(std::span<const SteerSpec> steers) {
    thread_.check();
    is_current_ = false;
    for (std::size_t i = 0; i < steers.size(); ++i) {
        const std::string path = "actors[" + std::to_string(i) + "].";
        const auto mover = need_actor(steers[i].name);
        if (!mover) return error(mover.error().kind, path + mover.error().message);
        if (steers[i].position)
            if (auto good = check_place(**mover, *steers[i].position, path + "position"); !good) return good;
        if (steers[i].clip)
            if (auto good = check_clip(*(*mover)->info->model, *steers[i].clip, path + "clip"); !good) return good;
    }
    for (const SteerSpec& steer : steers) {
        Mover& mover = *find(steer.name);
        if (!std::holds_alternative<SteeredBehaviour>(mover.spec)) behave(mover, SteeredBehaviour{});
        StepContext own = context();
        own.id = mover.id();
        own.scale = mover.scale;
        own.now_ns = now_ns_ - mover.behind_ns;
        ActorState steered = mover.now;
        dynamic_cast<Steered&>(*mover.behaviour).steer(steer, own, steered);
        const bool jumps = steered.position != mover.now.position || steered.orientation != mover.now.orientation;
        if (jumps)
            mover.jump([&](ActorState& now) {
                now.position = steered.position;
                now.orientation = steered.orientation;
            });
    }
    return {};
}

}  // namespace camrig::world
