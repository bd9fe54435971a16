#include "core/world/read/check_names.h"

#include <initializer_list>

#include "core/base/error_list.h"
#include "core/world/daylit.h"
#include "core/world/photometric.h"
#include "core/world/read/check_walkable.h"
#include "core/world/scene_names.h"

namespace camrig::world {
namespace {

std::string key_of(const std::string& path, std::string_view key) {
    return path.empty() ? std::string(key) : path + "." + std::string(key);
}

/// What bears this name could not be read, and that was told.
bool is_excused(const std::string& name) {
    const ErrorList* const list = ErrorList::current();
    return list && list->excuses(name);
}

/// As a light of a model is called after its object: `OBJECT.LIGHT`. Both may have dots of their own.
bool is_of_excused(const std::string& light) {
    for (std::size_t dot = light.find('.'); dot != std::string::npos; dot = light.find('.', dot + 1))
        if (is_excused(light.substr(0, dot))) return true;
    return false;
}

std::unexpected<Error> refuse(ErrorKind kind, const std::string& path, const std::string& why) {
    if (ErrorList* const list = ErrorList::current()) list->add(path, why);
    return error(kind, path + ": " + why);
}

std::unexpected<Error> unknown(const std::string& path, std::string_view what, const std::string& name,
                               const std::string& known) {
    if (is_excused(name)) return error(ErrorKind::not_found, "");
    return refuse(ErrorKind::not_found, path,
                  "no " + std::string(what) + " '" + name.substr(0, 80) + "'; known: " + known);
}

/// The first error of several checks. All of them are made, so that an ErrorList hears of each.
Result<void> first_error(std::initializer_list<Result<void>> checks) {
    for (const Result<void>& check : checks)
        if (!check) return check;
    return {};
}

/// `name` is one of `entries`.
template <typename Entries>
Result<void> check_in(const Entries& entries, const std::string& name, std::string_view what, const std::string& path) {
    if (entries.contains(name)) return {};
    return unknown(path, what, name, known_names(entries));
}

Result<void> check_light(const Scene& scene, const std::string& name, const std::string& path) {
    std::set<std::string> lights;
    for (const Light& light : scene.lights) {
        if (!light.group.empty() && light.name == name)
            return refuse(ErrorKind::invalid_argument, path,
                          "'" + name + "' is switched with its group '" + light.group + "'; name that");
        lights.insert(switch_name(light));
    }
    if (scene.environment.daylight) lights.insert(sun_name);
    if (!lights.contains(name) && is_of_excused(name)) return error(ErrorKind::not_found, "");
    return check_in(lights, name, "light", path);
}

Result<void> check_node(const Model& model, const std::string& node, const std::string& path) {
    if (node.empty()) return {};
    std::set<std::string> nodes;
    for (const Node& n : model.nodes) nodes.insert(n.name);
    if (nodes.contains(node)) return {};
    return refuse(ErrorKind::not_found, path,
                  "the model has no node '" + node.substr(0, 80) + "'; it has: " + known_names(nodes));
}

/// The model of an actor that is known; nullptr when the scene has none of its name, which is told at the actor.
const Model* model_of(const KnownNames& names, const std::string& actor) {
    const auto found = names.scene.models.find(names.actors.at(actor));
    return found == names.scene.models.end() ? nullptr : found->second.model.get();
}

Result<void> check_place(const KnownNames& names, const glm::dvec3& place, const std::string& path) {
    const auto why = why_unwalkable(names.scene, place);
    return why ? refuse(ErrorKind::invalid_argument, path, *why) : Result<void>();
}

/// Whether it puts its actor somewhere itself, at once.
bool begins_elsewhere(const BehaviourSpec& behaviour) {
    if (const auto* const sequence = std::get_if<SequenceBehaviour>(&behaviour))
        return !sequence->steps.empty() && begins_elsewhere(sequence->steps.front().behaviour);
    return places_actor(behaviour);
}

/// The kinds of behaviour, each with the names it uses.
struct BehaviourCheck {
    const Model& model;
    const KnownNames& names;
    const std::string& path;

    Result<void> clip(std::string_view key, const std::string& name) const {
        return check_clip(model, name, key_of(path, key));
    }
    Result<void> walk(const WalkManner& manner) const {
        const auto area = [&]() -> Result<void> {
            if (manner.area.empty()) return {};
            return check_in(names.scene.areas, manner.area, "area", key_of(path, "area"));
        };
        return first_error({area(), clip("clip", manner.clip), clip("idle_clip", manner.idle_clip)});
    }
    Result<void> actor(const std::string& name) const {
        return check_in(names.actors, name, "actor", key_of(path, "actor"));
    }
    Result<void> route(const std::string& name) const {
        return check_in(names.scene.routes, name, "route", key_of(path, "route"));
    }

    Result<void> operator()(const StandBehaviour& stand) const { return clip("clip", stand.clip); }
    Result<void> operator()(const SteeredBehaviour& steered) const { return clip("clip", steered.clip); }
    Result<void> operator()(const GoToBehaviour& go) const {
        return first_error({walk(go.walk), check_place(names, go.position, key_of(path, "position"))});
    }
    Result<void> operator()(const WanderBehaviour& wander) const { return walk(wander.walk); }
    Result<void> operator()(const GroupBehaviour& group) const { return walk(group.walk); }
    Result<void> operator()(const LookAtBehaviour& look) const {
        return first_error({look.actor.empty() ? Result<void>() : actor(look.actor), clip("clip", look.clip)});
    }
    Result<void> operator()(const FollowBehaviour& follow) const {
        return first_error({actor(follow.actor), walk(follow.walk)});
    }
    Result<void> operator()(const VehicleBehaviour& vehicle) const {
        return first_error({route(vehicle.route), clip("clip", vehicle.clip)});
    }
    Result<void> operator()(const RouteBehaviour& route_walk) const {
        using Mode = RouteBehaviour::Mode;
        if (auto done = first_error({clip("clip", route_walk.clip), route(route_walk.route)}); !done) return done;
        const bool closed = names.scene.routes.at(route_walk.route).closed;
        if (!route_walk.mode || *route_walk.mode == Mode::once || (*route_walk.mode == Mode::loop) == closed) return {};
        return refuse(ErrorKind::invalid_argument, key_of(path, "mode"),
                      closed ? "a closed route is walked in mode loop or once"
                             : "an open route is walked in mode ping_pong or once");
    }
    Result<void> operator()(const SequenceBehaviour& sequence) const {
        Result<void> all;
        for (std::size_t i = 0; i < sequence.steps.size(); ++i) {
            const SequenceStep& step = sequence.steps[i];
            const std::string place = key_of(path, "steps[" + std::to_string(i) + "]");
            all = first_error({all, check_behaviour(step.behaviour, model, names, place)});
            if (!step.event.empty())
                all = first_error({all, check_in(names.events, step.event, "event", place + ".until.event")});
        }
        return all;
    }
};

/// Who hangs on somebody at once does so on an actor that is there at once. Of one that nobody knows, others tell.
Result<void> check_is_there(const std::optional<Attachment>& attach, const KnownNames& names, const std::string& path) {
    if (!attach || !names.spawned.contains(attach->actor) || is_excused(attach->actor)) return {};
    std::set<std::string> there;
    for (const ActorSpec& actor : names.scene.actors) there.insert(actor.name);
    return refuse(ErrorKind::invalid_argument, key_of(path, "attach.actor"),
                  "'" + attach->actor + "' comes by an event only; there from the start: " + known_names(there));
}

/// Of an actor that is there from the start, comes now, or comes by an event.
Result<void> check_any_actor(const ActorSpec& actor, const KnownNames& names, const std::string& path) {
    const auto model = names.scene.models.find(actor.model);
    if (model == names.scene.models.end())
        return unknown(key_of(path, "model"), "model", actor.model, known_names(names.scene.models));
    const auto attachment = [&]() -> Result<void> {
        if (!actor.attach) return {};
        if (auto done = check_attachment(*actor.attach, names, key_of(path, "attach")); !done) return done;
        if (actor.attach->actor != actor.name) return {};
        return refuse(ErrorKind::invalid_argument, key_of(path, "attach.actor"), "an actor hangs on another");
    };
    const auto place = [&]() -> Result<void> {
        if (actor.object_class != person_class || actor.attach || begins_elsewhere(actor.behaviour)) return {};
        return check_place(names, actor.position, key_of(path, "position"));
    };
    return first_error({attachment(), place(),
                        check_behaviour(actor.behaviour, *model->second.model, names, key_of(path, "behaviour"))});
}

struct TriggerCheck {
    const KnownNames& names;
    const std::string path;

    Result<void> actor(const std::string& name, std::string_view key) const {
        if (name.empty()) return {};
        return check_in(names.actors, name, "actor", key_of(path, key));
    }
    Result<void> operator()(const AtTime&) const { return {}; }
    Result<void> operator()(const EveryTime&) const { return {}; }
    Result<void> operator()(const AtBorder& border) const {
        const char* key = border.enters ? "enter" : "leave";
        return first_error(
            {check_in(names.scene.areas, border.area, "area", key_of(path, key)), actor(border.actor, "actor")});
    }
    Result<void> operator()(const AtMeeting& meeting) const {
        return first_error({actor(meeting.actors[0], "meet[0]"), actor(meeting.actors[1], "meet[1]")});
    }
    Result<void> operator()(const AfterEvent& after) const {
        return check_in(names.events, after.event, "event", key_of(path, "event"));
    }
    Result<void> operator()(const AtArrival& arrival) const { return actor(arrival.actor, "arrived"); }
};

struct ActionCheck {
    const KnownNames& names;
    const std::string path;

    Result<void> actor(const std::string& name) const {
        return check_in(names.actors, name, "actor", key_of(path, "actor"));
    }
    Result<void> object(const std::string& name) const {
        if (names.actors.contains(name)) return {};
        return check_in(names.objects, name, "object", key_of(path, "object"));
    }
    Result<void> clip_of(const std::string& name, const std::string& clip) const {
        if (auto done = actor(name); !done) return done;
        const Model* const model = model_of(names, name);
        return model ? check_clip(*model, clip, key_of(path, "clip")) : Result<void>();
    }
    Result<void> operator()(const BehaveAction& action) const {
        if (auto done = actor(action.actor); !done) return done;
        const Model* const model = model_of(names, action.actor);
        return model ? check_behaviour(action.behaviour, *model, names, key_of(path, "behaviour")) : Result<void>();
    }
    Result<void> operator()(const StopAction& action) const { return clip_of(action.actor, action.clip); }
    Result<void> operator()(const StartAction& action) const { return actor(action.actor); }
    Result<void> operator()(const PlayAction& action) const { return clip_of(action.actor, action.clip); }
    Result<void> operator()(const SpawnAction& action) const {
        return check_any_actor(action.actor, names, key_of(path, "actor"));
    }
    Result<void> operator()(const RemoveAction& action) const { return actor(action.actor); }
    Result<void> operator()(const PickUpAction& action) const {
        return first_error({object(action.object), check_attachment(action.to, names, path)});
    }
    Result<void> operator()(const PutDownAction& action) const { return object(action.object); }
    Result<void> operator()(const LightAction& action) const {
        if (auto known = check_light(names.scene, action.light, key_of(path, "light")); !known) return known;
        if (!action.candela && !action.lux) return {};
        const std::string key = key_of(path, action.lux ? "lux" : "candela");
        const auto light = std::ranges::find(names.scene.lights, action.light, switch_name);
        if (light == names.scene.lights.end())
            return refuse(ErrorKind::invalid_argument, key, "the sun's are environment.daylight's");
        if ((light->type == LightType::directional) != action.lux.has_value())
            return refuse(
                ErrorKind::invalid_argument, key,
                "'" + action.light + "' is a " + (action.lux ? "lamp, give candela" : "directional light, give lux"));
        return unit_lux(names.scene.environment) ? Result<void>()
                                                 : refuse(ErrorKind::invalid_argument, key, std::string(needs_unit));
    }
    Result<void> operator()(const EnvironmentAction&) const { return {}; }
    Result<void> operator()(const CameraAction&) const { return {}; }
    Result<void> operator()(const FaultAction&) const { return {}; }
    Result<void> operator()(const ClearFaultAction&) const { return {}; }
    Result<void> operator()(const UserAction&) const { return {}; }
};

}  // namespace

KnownNames names_of(const Scene& scene) {
    KnownNames names{.scene = scene, .actors = {}, .spawned = {}, .objects = {}, .events = {}};
    for (const ActorSpec& actor : scene.actors) names.actors.emplace(actor.name, actor.model);
    for (const ObjectSpec& object : scene.objects) names.objects.insert(object.name);
    for (const EventSpec& event : scene.events) {
        names.events.insert(event.name);
        for (const Action& action : event.actions) add_spawned(action, names);
    }
    return names;
}

void add_spawned(const Action& action, KnownNames& names) {
    const auto* const spawn = std::get_if<SpawnAction>(&action);
    if (!spawn) return;
    const ActorSpec& actor = spawn->actor;
    if (!names.scene.models.contains(actor.model) && !is_excused(actor.model)) return;
    if (names.actors.emplace(actor.name, actor.model).second) names.spawned.insert(actor.name);
}

Result<void> check_clip(const Model& model, const std::string& clip, const std::string& path) {
    if (clip.empty() || model.find_animation(clip) >= 0) return {};
    std::set<std::string> clips;
    for (const Animation& animation : model.animations) clips.insert(animation.name);
    return refuse(ErrorKind::not_found, path,
                  "the model has no clip '" + clip.substr(0, 80) + "'; it has: " + known_names(clips));
}

Result<void> check_behaviour(const BehaviourSpec& behaviour, const Model& model, const KnownNames& names,
                             const std::string& path) {
    return std::visit(BehaviourCheck{model, names, path}, behaviour);
}

Result<void> check_mount(const Mount& mount, const KnownNames& names, const std::string& path) {
    if (auto done = check_in(names.actors, mount.actor, "actor", key_of(path, "actor")); !done) return done;
    const Model* const model = model_of(names, mount.actor);
    return model ? check_node(*model, mount.node, key_of(path, "node")) : Result<void>();
}

Result<void> check_attachment(const Attachment& attachment, const KnownNames& names, const std::string& path) {
    return check_mount({.actor = attachment.actor, .node = attachment.node}, names, path);
}

Result<void> check_object(const ObjectSpec& object, const KnownNames& names, const std::string& path) {
    const auto model = names.scene.models.find(object.model);
    if (model == names.scene.models.end())
        return unknown(key_of(path, "model"), "model", object.model, known_names(names.scene.models));
    return first_error(
        {check_clip(*model->second.model, object.clip, key_of(path, "clip")),
         object.attach ? check_attachment(*object.attach, names, key_of(path, "attach")) : Result<void>(),
         check_is_there(object.attach, names, path)});
}

Result<void> check_actor(const ActorSpec& actor, const KnownNames& names, const std::string& path) {
    return first_error({check_any_actor(actor, names, path), check_is_there(actor.attach, names, path)});
}

Result<void> check_event(const EventSpec& event, const KnownNames& names, const std::string& path) {
    Result<void> all = std::visit(TriggerCheck{names, key_of(path, "when")}, event.when);
    for (std::size_t i = 0; i < event.actions.size(); ++i)
        all = first_error({all, check_action(event.actions[i], names, key_of(path, "do[" + std::to_string(i) + "]"))});
    return all;
}

Result<void> check_action(const Action& action, const KnownNames& names, const std::string& path) {
    return std::visit(ActionCheck{names, path}, action);
}

Result<void> check_follows(const std::string& actor, FollowGraph& graph, const std::string& path) {
    const auto circle = graph.circle_of(actor);
    if (!circle) return {};
    return refuse(ErrorKind::invalid_argument, key_of(path, "behaviour"), *circle + ": somebody must lead");
}

Result<void> check_event_loop(const EventSpec& event, std::span<const EventSpec> all, const std::string& path) {
    // Backwards along "fires at once after": every event has one trigger, so the way is a line or a circle.
    std::map<std::string, const AfterEvent*> at_once;
    const auto add = [&](const EventSpec& one) {
        const auto* after = std::get_if<AfterEvent>(&one.when);
        if (after && after->delay_ns == 0) at_once[one.name] = after;
    };
    for (const EventSpec& one : all) add(one);
    add(event);
    std::string trail = "'" + event.name + "'", name = event.name;
    for (std::size_t i = 0; i <= at_once.size(); ++i) {
        const auto found = at_once.find(name);
        if (found == at_once.end()) return {};
        name = found->second->event;
        trail = "'" + name + "' -> " + trail;
        if (name == event.name)
            return refuse(ErrorKind::invalid_argument, key_of(path, "when.event"),
                          "the event fires itself at one instant: " + trail + "; give after_s somewhere");
    }
    return {};
}

}  // namespace camrig::world
