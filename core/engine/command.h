#pragma once

#include <concepts>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/ids.h"
#include "core/base/named.h"
#include "core/base/result.h"
#include "core/base/time.h"
#include "core/stream/frame_bus.h"
#include "core/stream/reader_log.h"
#include "core/stream/statistics.h"
#include "core/truth/ground.h"
#include "core/truth/truth.h"
#include "core/world/camera.h"
#include "core/world/scene.h"
#include "core/world/world.h"

/// Commands as data: what clients can ask of the engine, each with the type of its reply. The control side makes them
/// from JSON, the engine applies them between instants, in the order they came.
namespace camrig::engine {

enum class RunMode : std::uint8_t { realtime, lockstep };
inline std::span<const Named<RunMode>> names_of(std::type_identity<RunMode>) {
    static constexpr Named<RunMode> names[] = {{RunMode::realtime, "realtime"}, {RunMode::lockstep, "lockstep"}};
    return names;
}
enum class OverloadPolicy : std::uint8_t { drop, slow };
inline std::span<const Named<OverloadPolicy>> names_of(std::type_identity<OverloadPolicy>) {
    static constexpr Named<OverloadPolicy> names[] = {{OverloadPolicy::drop, "drop"}, {OverloadPolicy::slow, "slow"}};
    return names;
}

struct CameraReply {
    CameraId id{};
    world::Camera camera;
    camera::CameraState now;     ///< pose and zoom; of a mounted camera, at its latest due instant
    std::int64_t sequence = -1;  ///< of the latest due frame; -1: none yet
    std::size_t readers = 0;
    TimeNs applied_ns = 0;  ///< world time from which this state shows
};

struct WorldState {
    std::string scene;  ///< its name
    std::string scene_file;
    RunMode mode = RunMode::realtime;
    OverloadPolicy overload = OverloadPolicy::drop;
    world::Quality quality = world::Quality::simple;
    bool paused = false;
    TimeNs world_ns = 0;
    TimeNs step_ns = 0;
    std::uint64_t seed = 0;
    std::size_t objects = 0;
    std::size_t actors = 0;
    std::size_t cameras = 0;
    world::StateHash state;  ///< of actors and lights, at the world's last step
    std::vector<std::string> places;
    TimeNs applied_ns = 0;
};

struct Applied {
    TimeNs applied_ns = 0;  ///< world time from which it shows
};
/// The new state of something that was created or changed, and from when on it shows.
template <typename Report>
struct AppliedReport {
    Report report;
    TimeNs applied_ns = 0;
};
using ActorChange = AppliedReport<world::ActorReport>;
using EventChange = AppliedReport<world::EventReport>;

struct CreateCamera {
    using Reply = CameraReply;
    std::string name;
    std::optional<std::string> place;  ///< pose and field of view of a place of the scene, under the patch
    world::CameraPatch patch;
};
struct SetCamera {
    using Reply = CameraReply;
    std::string name;
    world::CameraPatch patch;
    TimeNs duration_ns = 0;  ///< world time over which pose and field of view move to their new values
};
struct DeleteCamera {
    using Reply = Applied;
    std::string name;
};
struct GetCamera {
    using Reply = CameraReply;
    std::string name;
};
struct PtzReply {
    camera::PtzStatus status;
    TimeNs world_ns = 0;    ///< world time of `status`
    TimeNs arrives_ns = 0;  ///< world time at which it stops; the largest value: never
    std::map<std::string, camera::PtzPosition> presets;
    TimeNs applied_ns = 0;  ///< world time from which pictures show the command
    std::map<std::string, camera::PtzTour> tours = {};
    std::optional<std::string> tour = {};  ///< the one that runs
};
struct MovePtz {
    using Reply = PtzReply;
    std::string camera;
    camera::PtzMove move;
};
/// What a PTZ head does with its presets, or its home position. `add` sets a new one; already_exists if there is one.
struct PtzPresets {
    using Reply = PtzReply;
    enum class Action : std::uint8_t { set, add, go_to, remove, set_home, go_home };
    std::string camera;
    std::string preset = {};
    Action action = Action::go_to;
    double speed = 1.0;  ///< of go_to and go_home: a share of the head's
};
/// What a PTZ head does with tours of its presets.
struct PtzTours {
    using Reply = PtzReply;
    enum class Action : std::uint8_t { set, start, remove };
    std::string camera;
    std::string tour = {};
    camera::PtzTour stops = {};  ///< of Action::set
    Action action = Action::start;
};
struct StopPtz {
    using Reply = PtzReply;
    std::string camera;
    bool pan_tilt = true;
    bool zoom = true;
};
struct GetPtz {
    using Reply = PtzReply;
    std::string camera;
};
/// A fault of a camera, and the world time from which pictures show it.
struct FaultReply {
    std::string camera;
    fault::FaultRef fault;
    TimeNs applied_ns = 0;
};
struct SetFault {
    using Reply = FaultReply;
    std::string camera;
    fault::FaultSpec fault;
};
/// Ends the faults that match all of these.
struct ClearFaults {
    struct Reply {
        std::size_t cleared = 0;
        TimeNs applied_ns = 0;
    };
    std::optional<std::uint64_t> id;
    std::string camera;     ///< empty: of all
    std::string kind;       ///< empty: of every kind
    bool by_wiper = false;  ///< only those that a wiper removes from the glass
};
struct ListFaults {
    struct Reply {
        std::vector<FaultReply> faults;  ///< present and future ones
        TimeNs world_ns = 0;
    };
    std::string camera;  ///< empty: of all
};
/// The effects of faults on readers (lost packets, broken connections), of events after number `since`.
struct GetReaderLog {
    using Reply = stream::ReaderLog::Since;
    std::uint64_t since = 0;
    std::string camera;  ///< empty: of all
};
struct ListCameras {
    using Reply = std::vector<CameraReply>;
};
/// The scene is loaded by the caller, off the engine's thread. Cameras stay; those of the scene are added unless their
/// names are taken.
struct LoadWorld {
    using Reply = WorldState;
    world::SceneRef scene;
};
struct GetWorld {
    using Reply = WorldState;
};
struct PauseWorld {
    using Reply = WorldState;
};
struct ResumeWorld {
    using Reply = WorldState;
};
/// Lockstep (or paused realtime): moves the world; answers when every connected reader was sent every due frame.
struct StepWorld {
    using Reply = WorldState;
    TimeNs duration_ns = 0;
    TimeNs timeout_ns = 10 * ns_per_s;
};

/// The world as commands see it: at its last step, which may be some ms ahead of the cameras' pictures. A client that
/// holds it can request pictures and truth of it, all of one moment (stream::FetchRequest::instant).
struct HeldInstant final : stream::Instant {
    world::SnapshotRef snapshot;
    TimeNs monotonic_ns = 0;
    /// Sequence number of its pictures: below 0, unlike those of cameras' frames, and different for each instant.
    std::int64_t sequence = -1;
    world::SceneRef scene;     ///< of the snapshot
    bool stands_still = true;  ///< the world does not move by itself now
    RunMode mode = RunMode::realtime;
};
struct GetInstant {
    using Reply = std::shared_ptr<const HeldInstant>;
};

struct ActorList {
    std::vector<world::ActorReport> actors;  ///< in the order they came
    world::StateHash state;
};
struct EventLog {
    std::vector<world::EventRecord> events;
    std::uint64_t last = 0;    ///< sequence of the newest event of all
    std::uint64_t missed = 0;  ///< events after `since` that are not kept any more
};

struct ListActors {
    using Reply = ActorList;
};
struct SpawnActor {
    using Reply = ActorChange;
    world::ActorSpec actor;
};
struct RemoveActor {
    using Reply = Applied;
    std::string name;
};
struct SetActor {
    using Reply = ActorChange;
    world::ActorPatch patch;
};
struct SteerActors {
    using Reply = Applied;
    std::vector<world::SteerSpec> actors;
};
using ObjectChange = AppliedReport<world::ObjectReport>;
struct SpawnObject {
    using Reply = ObjectChange;
    world::ObjectSpec object;
};
struct SetObject {
    using Reply = ObjectChange;
    world::ObjectPatch patch;
};
struct RemoveObject {
    using Reply = Applied;
    std::string name;
};
struct ListEvents {
    using Reply = std::vector<world::EventReport>;
};
struct AddEvent {
    using Reply = EventChange;
    world::EventSpec event;
};
struct RemoveEvent {
    using Reply = Applied;
    std::string name;
};
/// Carries out an event's actions, at once.
struct Act {
    using Reply = Applied;
    std::vector<world::Action> actions;
};
/// Answers when an event has fired after number `since`, or when the time is over.
struct WaitEvents {
    using Reply = EventLog;
    std::uint64_t since = 0;
    TimeNs timeout_ns = 10 * ns_per_s;
};
/// How far the world may run, in real time; from a rig that is held (EngineOptions::is_held) it goes nowhere else.
struct SetLimit {
    struct Reply {
        TimeNs world_ns = 0;
        TimeNs limit_ns = max_time_ns;
        std::size_t waiting = 0;  ///< commands that wait for their time
    };
    std::optional<TimeNs> until_ns = {};  ///< nullopt: unchanged
    /// The world time now, by the caller's clock: the rig's is set to it, and frames that are skipped are counted as
    /// dropped for `held`. A difference of less than 2 ms is slewed (500 ppm).
    std::optional<TimeNs> clock_ns = {};
};
/// Hashes of the rig's state, to compare rigs that run the same scene.
struct GetDigest {
    struct Reply {
        TimeNs world_ns = 0;
        TimeNs state_ns = 0;  ///< of the world's last step
        std::uint64_t value = 0;
        world::StateHash world;
        std::uint64_t cameras = 0;
        std::uint64_t commands = 0;  ///< of the commands carried out, with their world times
        std::uint64_t command_count = 0;
        std::vector<world::NamedDigest> parts;
    };
    bool with_parts = false;
};
struct GetStats {
    using Reply = stream::RigReport;
};
/// The truth of the camera's latest due frame; waits for one that shows min_ns or later.
struct GetTruth {
    using Reply = truth::TruthRef;
    std::string camera;
    TimeNs min_ns = 0;
    /// The truth of what the camera would show at this instant; null: of its latest due frame.
    std::shared_ptr<const HeldInstant> instant = {};
    std::optional<truth::GroundGrid> ground = {};  ///< also tells which cells of this grid are seen; nullopt: of none
};

/// A command. `done` is called exactly once and must not block: on the engine's thread or, if refused, within post().
template <typename C>
struct Request {
    C command;
    std::function<void(Result<typename C::Reply>)> done;
    /// World time at which it is carried out, after the frames that are due then; nullopt: at once. Only for Timed<C>.
    std::optional<TimeNs> at_ns = {};
    /// The command as one line of text, for the command log; null: it did not come as JSON-RPC.
    std::shared_ptr<const std::string> text = {};
};

using Command =
    std::variant<Request<CreateCamera>, Request<SetCamera>, Request<DeleteCamera>, Request<GetCamera>,
                 Request<ListCameras>, Request<MovePtz>, Request<PtzPresets>, Request<PtzTours>, Request<StopPtz>,
                 Request<GetPtz>, Request<SetFault>, Request<ClearFaults>, Request<ListFaults>, Request<GetReaderLog>,
                 Request<LoadWorld>, Request<GetWorld>, Request<PauseWorld>, Request<ResumeWorld>, Request<StepWorld>,
                 Request<ListActors>, Request<SpawnActor>, Request<RemoveActor>, Request<SetActor>,
                 Request<SteerActors>, Request<SpawnObject>, Request<SetObject>, Request<RemoveObject>,
                 Request<ListEvents>, Request<AddEvent>, Request<RemoveEvent>, Request<Act>, Request<WaitEvents>,
                 Request<GetInstant>, Request<GetStats>, Request<GetTruth>, Request<SetLimit>, Request<GetDigest>>;

template <typename C, typename... Of>
concept OneOf = (std::same_as<C, Of> || ...);
/// Commands that change cameras or what is in the world. Replicas carry them out at the same world time.
template <typename C>
concept Change = OneOf<C, CreateCamera, SetCamera, DeleteCamera, MovePtz, PtzPresets, PtzTours, StopPtz, SetFault,
                       ClearFaults, SpawnActor, RemoveActor, SetActor, SteerActors, SpawnObject, SetObject,
                       RemoveObject, AddEvent, RemoveEvent, Act>;
/// Commands that may be given a world time: their methods have the parameter at_ns.
template <typename C>
concept Timed = Change<C> || OneOf<C, GetDigest>;
/// Commands that the command log contains, with the world time at which they were carried out.
template <typename C>
concept Logged = Change<C> || OneOf<C, LoadWorld, PauseWorld, ResumeWorld, StepWorld>;

/// Records the commands that were carried out (Logged<C>), in order, those of several actions (Act) of which a later
/// one failed too. Called on the engine's thread.
class CommandJournal {
public:
    virtual ~CommandJournal() = default;
    virtual void note(TimeNs at_ns, const std::string& text, bool has_failed) = 0;
};

/// Takes commands: the engine's bounded queue. Any thread. A full queue answers `resource_exhausted` at once.
class CommandPort {
public:
    virtual ~CommandPort() = default;
    virtual void post(Command command) = 0;
};

inline constexpr std::size_t max_queued_commands = 1024;
inline constexpr std::size_t max_cameras = 256;
/// All cameras together; at 8 bytes per pixel on the device and 4 in each frame this is about 2 GiB. A GPU that
/// converts colours gives a frame for each pixel format that readers take, 1.5 bytes a pixel for most.
inline constexpr std::int64_t max_total_pixels = std::int64_t{160} << 20;

}  // namespace camrig::engine
