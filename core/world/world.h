#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/world/object_report.h"
#include "core/world/scene.h"
#include "core/world/snapshot.h"

namespace camrig::world {

class WorldPast;

inline constexpr std::size_t max_world_actors = 5000;
inline constexpr std::size_t max_world_events = 1000;

/// What an event does to a camera; the world has no cameras itself.
struct CameraMove {
    TimeNs world_ns = 0;  ///< from when on
    std::variant<CameraAction, FaultAction, ClearFaultAction> action;
};

/// Something that moves and has gone from the world, as it was then.
struct Departure {
    TimeNs world_ns = 0;  ///< from when on it is not there
    Instance instance;
};

/// A hash of all that decides the world's future, at its last step: where actors are, what their behaviours remember
/// (random streams are counted, so the counts are them), events, objects, lights. Equal states have equal hashes.
struct StateHash {
    TimeNs world_ns = 0;
    std::uint64_t value = 0;
};

/// The hash of a part of something, to find what differs.
struct NamedDigest {
    std::string name;
    std::uint64_t value = 0;
};

/// The world: objects, actors and their behaviours, events, advanced in fixed steps of its own.
///
/// Thread: the engine's. Cameras sample it between steps by interpolation, so they never change what happens in it.
/// Deterministic: the state after step k is a pure function of scene, seed and the commands applied before it.
///
/// Commands act at the last step, last_step_ns(): snapshots from there on show them. A command that fails changes
/// nothing.
class World {
public:
    static Result<std::unique_ptr<World>> create(SceneRef scene, std::uint64_t seed);
    virtual ~World() = default;

    virtual const Scene& scene() const = 0;
    /// Runs steps until the last one is at or after `world_ns`. Never goes back.
    virtual void advance_to(TimeNs world_ns) = 0;
    virtual TimeNs last_step_ns() const = 0;
    /// The world at `world_ns`, to the nanosecond: any time of the last 250 ms before the last step (StepHistory), from
    /// the world's begin on. The same whenever and in whatever order it is asked for, but for changes at the last step,
    /// which may still come.
    virtual SnapshotRef snapshot(TimeNs world_ns) const = 0;
    /// All of it from `from_ns` on, as far as it is kept, for who looks at it later and on another thread.
    virtual std::shared_ptr<const WorldPast> past(TimeNs from_ns) const = 0;

    virtual std::vector<ActorReport> actors() const = 0;
    virtual Result<ActorReport> spawn_actor(const ActorSpec& spec) = 0;
    virtual Result<void> remove_actor(const std::string& name) = 0;
    virtual Result<ActorReport> change_actor(const ActorPatch& patch) = 0;
    /// All of them or none.
    virtual Result<void> steer_actors(std::span<const SteerSpec> steers) = 0;

    virtual Result<void> spawn_object(const ObjectSpec& spec) = 0;
    /// Of an object or an actor.
    virtual Result<void> change_object(const ObjectPatch& patch) = 0;
    virtual Result<void> remove_object(const std::string& name) = 0;

    /// Whether a camera can be fixed to this now; messages begin with `path`.
    virtual Result<void> check_mount(const Mount& mount, const std::string& path) const = 0;

    virtual std::vector<EventReport> events() const = 0;
    virtual Result<EventReport> add_event(const EventSpec& spec) = 0;
    virtual Result<void> remove_event(const std::string& name) = 0;
    /// Does at the last step what an event would; its record is that of an event `event.act`. Nothing is done where
    /// a name is unknown; another error names the action (do[i]), and those before it are done.
    virtual Result<void> act(const std::vector<Action>& actions) = 0;

    /// The events that have fired since the last call; when there are very many, the newest of them.
    virtual std::vector<EventRecord> take_records() = 0;
    virtual std::vector<CameraMove> take_camera_moves() = 0;
    /// What has gone since the last call, in this order; when there is very much of it, the newest.
    virtual std::vector<Departure> take_departures() = 0;

    /// The same world once more, which goes its own way: what becomes of this one if nobody says anything. Its thread
    /// is the first that moves it.
    virtual std::unique_ptr<World> copy() const = 0;

    virtual std::size_t object_count() const = 0;
    virtual std::size_t actor_count() const = 0;
    virtual StateHash state_hash() const = 0;
    /// Of each of its parts, at the last step.
    virtual std::vector<NamedDigest> digests() const = 0;
};

}  // namespace camrig::world
