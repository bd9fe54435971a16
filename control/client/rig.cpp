
#include <system_error>

#include <camrig/rig.h>

#include "control/client/camera_file.h"
#include "control/client/camera_json.h"
#include "control/client/connections.h"
#include "control/client/member_json.h"

namespace camrig::client {
namespace {

using nlohmann::json;

/// The rig gives its own answer when its time is over; it needs to be heard.
constexpr std::chrono::seconds answer_margin{20};

}  // namespace

Rig connect(const ConnectOptions& options) {
    Rig rig(std::make_shared<Connections>(options));
    rig.info();
    return rig;
}

Camera Rig::create_camera(const std::string& name, const CameraOptions& options) const {
    json params = params_of(options);
    params["name"] = name;
    connections_->call("camera.create", params);
    return {connections_, name};
}

std::vector<Camera> Rig::create_cameras(const std::filesystem::path& file) const {
    auto described = read_camera_file(file);
    if (!described) throw Error(std::string(to_string(described.error().kind)), described.error().message);
    std::vector<Camera> made;
    for (const json& one : *described) {
        try {
            const json answer = connections_->call("camera.create", one);
            made.push_back({connections_, answer.at("name").get<std::string>()});
        } catch (const Error& why) {
            throw Error(why.kind(), camera_in_file(file, made.size()) + why.what());
        }
    }
    return made;
}

Camera Rig::camera(const std::string& name) const {
    connections_->call("camera.get", {{"name", name}});
    return {connections_, name};
}

std::vector<Camera> Rig::cameras() const {
    std::vector<Camera> all;
    for (const CameraState& state : camera_states()) all.push_back({connections_, state.name});
    return all;
}

std::vector<CameraState> Rig::camera_states() const {
    const json answer = connections_->call("camera.list");
    std::vector<CameraState> states;
    for (const json& one : answer.value("cameras", json::array())) states.push_back(camera_state_of(one));
    return states;
}

WorldStatus Rig::step(std::chrono::nanoseconds how_far, std::chrono::milliseconds timeout) const {
    return world_status_of(connections_->call("world.step", {{"nanoseconds", how_far.count()}}, timeout));
}

WorldStatus Rig::pause() const {
    return world_status_of(connections_->call("world.pause"));
}

WorldStatus Rig::resume() const {
    return world_status_of(connections_->call("world.resume"));
}

WorldStatus Rig::status() const {
    return world_status_of(connections_->call("world.status"));
}

std::filesystem::path Rig::save(const std::string& name) const {
    return connections_->call("world.save", {{"name", name}}).at("file").get<std::string>();
}

WorldStatus Rig::load(const std::filesystem::path& scene, std::chrono::milliseconds timeout) const {
    // A file of ours is named so that the rig finds it too; else it is a shipped scene, or a path of the rig.
    std::error_code ignored;
    const auto found = std::filesystem::is_regular_file(scene, ignored) ? std::filesystem::absolute(scene) : scene;
    return world_status_of(connections_->call("world.load", {{"scene", found.string()}}, timeout));
}

std::vector<ActorState> Rig::actors() const {
    return read_list<ActorState>("actors", connections_->call("actor.list"));
}

Applied<ActorState> Rig::spawn_actor(const std::string& name, const std::string& model,
                                     const ActorOptions& options) const {
    json params = json_of(options);
    params["name"] = name;
    params["model"] = model;
    return read_applied<ActorState>("actor", connections_->call("actor.spawn", params));
}

Applied<ActorState> Rig::set_actor(const std::string& name, const ActorChanges& changes) const {
    json params = json_of(changes);
    params["name"] = name;
    return read_applied<ActorState>("actor", connections_->call("actor.set", params));
}

std::int64_t Rig::steer_actors(const std::vector<Steering>& actors) const {
    return connections_->call("actor.steer", {{"actors", json_of(actors)}}).value("applied_ns", std::int64_t{0});
}

void Rig::remove_actor(const std::string& name) const {
    connections_->call("actor.remove", {{"name", name}});
}

std::vector<ObjectState> Rig::objects() const {
    return read_list<ObjectState>("objects", connections_->call("object.list"));
}

ObjectInfo Rig::object(const std::string& name) const {
    return read_answer<ObjectInfo>("object", connections_->call("object.get", {{"name", name}}));
}

Applied<ObjectState> Rig::spawn_object(const std::string& name, const std::string& model,
                                       const ObjectOptions& options) const {
    json params = json_of(options);
    params["name"] = name;
    params["model"] = model;
    return read_applied<ObjectState>("object", connections_->call("object.spawn", params));
}

Applied<ObjectState> Rig::set_object(const std::string& name, const ObjectChanges& changes) const {
    json params = json_of(changes);
    params["name"] = name;
    return read_applied<ObjectState>("object", connections_->call("object.set", params));
}

void Rig::remove_object(const std::string& name) const {
    connections_->call("object.remove", {{"name", name}});
}

std::vector<EventState> Rig::events() const {
    return read_list<EventState>("events", connections_->call("event.list"));
}

Applied<EventState> Rig::add_event(const std::string& name, const json& when, const json& actions, int limit) const {
    const json params{{"name", name}, {"when", when}, {"do", actions}, {"limit", limit}};
    return read_applied<EventState>("event", connections_->call("event.add", params));
}

std::int64_t Rig::act(const json& actions) const {
    return connections_->call("event.act", {{"do", actions}}).value("applied_ns", std::int64_t{0});
}

void Rig::remove_event(const std::string& name) const {
    connections_->call("event.remove", {{"name", name}});
}

EventLog Rig::wait_events(std::int64_t since, std::chrono::milliseconds timeout) const {
    const double timeout_s = std::chrono::duration<double>(timeout).count();
    const json params{{"since", since}, {"timeout_s", timeout_s}};
    return read_answer<EventLog>("events", connections_->call("event.wait", params, timeout + answer_margin));
}

Applied<FaultState> Rig::set_fault(const std::string& camera, const std::string& kind,
                                   const FaultOptions& options) const {
    json params = json_of(options);
    params["camera"] = camera;
    params["kind"] = kind;
    return read_applied<FaultState>("fault", connections_->call("fault.set", params));
}

std::int64_t Rig::clear_faults(const std::string& camera) const {
    return connections_->call("fault.clear", {{"camera", camera}})["cleared"];
}

std::int64_t Rig::clear_fault(std::int64_t id) const {
    return connections_->call("fault.clear", {{"id", id}})["cleared"];
}

std::int64_t Rig::wipe(const std::string& camera) const {
    return connections_->call("fault.wipe", {{"camera", camera}})["cleared"];
}

std::vector<FaultState> Rig::faults() const {
    return read_list<FaultState>("faults", connections_->call("fault.list"));
}

ReaderLog Rig::fault_log(const std::string& camera, std::int64_t since) const {
    json params{{"since", since}};
    if (!camera.empty()) params["camera"] = camera;
    return read_answer<ReaderLog>("fault.log", connections_->call("fault.log", params));
}

json Rig::visibility(const json& params) const {
    return connections_->call("truth.network", params);
}

json Rig::calibrate_plate(const json& task) const {
    return connections_->call("plate.calibrate", task);
}

json Rig::plate_light(const json& known) const {
    return connections_->call("plate.light", known);
}

json Rig::stats() const {
    return connections_->call("stats.get");
}

json Rig::info() const {
    return connections_->call("server.info");
}

json Rig::call(const std::string& method, const json& params) const {
    return connections_->call(method, params);
}

}  // namespace camrig::client
