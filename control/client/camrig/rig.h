#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <camrig/camera.h>
#include <camrig/error.h>
#include <camrig/parameters.h>
#include <nlohmann/json.hpp>

namespace camrig::client {

struct ConnectOptions {
    std::string control = {};  ///< a socket's path or HOST:PORT; empty: as for the command line ($CAMRIG_CONTROL, ..)
    std::string token = {};    ///< for TCP beyond this machine; a rig of this user is found with its key
    std::chrono::milliseconds timeout{30'000};  ///< longest wait of a call, for the connection and for the answer
};

/// A running rig. Copies are the same rig.
///
/// Thread: any; calls of different threads travel on connections of their own and do not wait for each other. Every
/// call throws Error. A request is never sent twice: when the connection breaks in the middle (`unavailable`), the
/// caller decides.
class Rig {
public:
    // Cameras
    Camera create_camera(const std::string& name, const CameraOptions& options = {}) const;
    /// Those of a cameras file: a camera as camera.get gives it, a list of them, or {"cameras": [...]}. When one cannot
    /// be made, those before it stay, and the error names it.
    std::vector<Camera> create_cameras(const std::filesystem::path& file) const;
    /// A camera that exists, else Error not_found.
    Camera camera(const std::string& name) const;
    /// In the order they were made.
    std::vector<Camera> cameras() const;
    /// The same with their states, in one call.
    std::vector<CameraState> camera_states() const;

    // World
    /// Lockstep, or paused: moves the world and returns when every due frame was sent to its readers. A reader that
    /// holds an instant up for longer than 10 s is named in the error.
    WorldStatus step(std::chrono::nanoseconds how_far,
                     std::chrono::milliseconds timeout = std::chrono::minutes(2)) const;
    WorldStatus pause() const;
    WorldStatus resume() const;
    WorldStatus status() const;
    /// The file in which a rig that keeps a log (serve --log) has saved its world, beside that log.
    std::filesystem::path save(const std::string& name) const;
    /// Another scene. The path is the rig's, so a relative one is made absolute here.
    WorldStatus load(const std::filesystem::path& scene,
                     std::chrono::milliseconds timeout = std::chrono::minutes(2)) const;

    // Actors, objects, events and faults: docs/actors.md, docs/faults.md and docs/control-protocol.md have what they
    // mean
    std::vector<ActorState> actors() const;
    Applied<ActorState> spawn_actor(const std::string& name, const std::string& model,
                                    const ActorOptions& options = {}) const;
    Applied<ActorState> set_actor(const std::string& name, const ActorChanges& changes) const;
    /// Moves actors by a program of your own, all or none of them. Returns the world time from which it shows.
    std::int64_t steer_actors(const std::vector<Steering>& actors) const;
    void remove_actor(const std::string& name) const;
    /// Everything that has an identity in pictures, actors too.
    std::vector<ObjectState> objects() const;
    /// One of them, with its box.
    ObjectInfo object(const std::string& name) const;
    /// Puts in what stands where it is.
    Applied<ObjectState> spawn_object(const std::string& name, const std::string& model,
                                      const ObjectOptions& options = {}) const;
    /// Hides, shows, scales an object or an actor, or moves an object.
    Applied<ObjectState> set_object(const std::string& name, const ObjectChanges& changes) const;
    void remove_object(const std::string& name) const;
    std::vector<EventState> events() const;
    /// A trigger and actions are JSON: {{"enter", "door"}}, and a list of {{"action", "stop"}, {"actor", "anna"}}.
    Applied<EventState> add_event(const std::string& name, const nlohmann::json& when,
                                  const nlohmann::json& actions = nlohmann::json::array(), int limit = 0) const;
    /// Does at once what an event's actions do; the world time from which it shows.
    std::int64_t act(const nlohmann::json& actions) const;
    void remove_event(const std::string& name) const;
    /// What has fired after number `since`; waits up to `timeout` for one.
    EventLog wait_events(std::int64_t since = 0, std::chrono::milliseconds timeout = std::chrono::seconds(10)) const;
    /// Lets a camera fail.
    Applied<FaultState> set_fault(const std::string& camera, const std::string& kind,
                                  const FaultOptions& options = {}) const;
    /// Ends the faults of a camera, or one fault by its id; how many.
    std::int64_t clear_faults(const std::string& camera) const;
    std::int64_t clear_fault(std::int64_t id) const;
    /// Wipes the glass before a camera's lens: ends dirt, drops and condensation; how many.
    std::int64_t wipe(const std::string& camera) const;
    /// The faults that are not over.
    std::vector<FaultState> faults() const;
    /// What faults let readers meet after event `since`, of one camera or (empty) of all.
    ReaderLog fault_log(const std::string& camera = "", std::int64_t since = 0) const;
    /// Who sees whom, and what cameras share (truth.network, docs/truth.md). `params`: cameras, classes, ..
    nlohmann::json visibility(const nlohmann::json& params = nlohmann::json::object()) const;
    /// From where a photo was taken (plate.calibrate, docs/backdrops.md). `task`: size, points, heights, ..
    nlohmann::json calibrate_plate(const nlohmann::json& task) const;
    /// Its sun and sky (plate.light). `known`: sun, or time and place, or shadow and camera.
    nlohmann::json plate_light(const nlohmann::json& known) const;

    // The rig
    nlohmann::json stats() const;
    nlohmann::json info() const;
    /// Any method of the control protocol, by its name.
    nlohmann::json call(const std::string& method, const nlohmann::json& params = nlohmann::json::object()) const;

private:
    friend Rig connect(const ConnectOptions& options);
    explicit Rig(std::shared_ptr<Connections> connections) : connections_(std::move(connections)) {}

    std::shared_ptr<Connections> connections_;
};

/// Connects to a running rig and checks that it answers; Error unavailable when nobody does.
Rig connect(const ConnectOptions& options = {});

}  // namespace camrig::client
