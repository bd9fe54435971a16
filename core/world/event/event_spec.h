#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "core/base/time.h"
#include "core/camera/clock_spec.h"
#include "core/camera/pose.h"
#include "core/fault/fault_plan.h"
#include "core/world/actor_spec.h"
#include "core/world/daylight_spec.h"
#include "core/world/fog_spec.h"

/// Events as data: when something happens, and what happens then. docs/scene-format.md explains each.
namespace camrig::world {

struct AtTime {
    TimeNs at_ns = 0;
};
struct EveryTime {
    TimeNs period_ns = ns_per_s;
    std::optional<TimeNs> first_ns;  ///< nullopt: after one period
};
/// An actor comes into an area or goes out of it.
struct AtBorder {
    bool enters = true;
    std::string area;
    std::string actor;         ///< empty: any
    std::string object_class;  ///< empty: any
};
/// Two actors come closer than a distance.
struct AtMeeting {
    std::array<std::string, 2> actors;
    double distance_m = 1.5;
};
/// Another event fires.
struct AfterEvent {
    std::string event;
    TimeNs delay_ns = 0;
};
/// An actor has done what its behaviour was to do.
struct AtArrival {
    std::string actor;
};
using Trigger = std::variant<AtTime, EveryTime, AtBorder, AtMeeting, AfterEvent, AtArrival>;

struct BehaveAction {
    std::string actor;
    BehaviourSpec behaviour;
};
/// Holds an actor where it is; StartAction lets it go on with what it did.
struct StopAction {
    std::string actor;
    std::string clip;
};
struct StartAction {
    std::string actor;
};
struct PlayAction {
    std::string actor;
    std::string clip;
    double speed = 1.0;
    std::optional<TimeNs> duration_ns;  ///< nullopt: until told otherwise
};
struct SpawnAction {
    ActorSpec actor;
};
struct RemoveAction {
    std::string actor;
};
struct PickUpAction {
    std::string object;
    Attachment to;
};
struct PutDownAction {
    std::string object;
    std::optional<glm::dvec3> position;  ///< nullopt: below where it hangs
};
struct LightAction {
    std::string light;
    std::optional<double> intensity, candela, lux;  ///< one of them, or none: it stays
    std::optional<glm::vec3> color;
    double flicker_hz = 0.0;  ///< over 0: goes on and off by chance, so often a second
    std::optional<TimeNs> duration_ns;
};
struct EnvironmentAction {
    std::optional<glm::vec3> background, sky, ground;
    std::optional<double> exposure;
    std::optional<double> glow;
    std::optional<DaylightSpec> daylight;
    std::optional<FogSpec> fog;
};
struct CameraAction {
    std::string camera;
    std::optional<camera::Pose> pose;
    std::optional<double> vfov_rad;
    std::optional<camera::ClockSpec> clock;  ///< at once, and all of it
    TimeNs duration_ns = 0;
};
/// A camera fails from then on.
struct FaultAction {
    std::string camera;
    fault::FaultSpec fault;
    std::optional<TimeNs> duration_ns;  ///< nullopt: until it is cleared
};
struct ClearFaultAction {
    std::string camera;
    std::string kind;  ///< empty: all
};
struct UserAction {
    std::string data = "null";  ///< JSON text
};
using Action = std::variant<BehaveAction, StopAction, StartAction, PlayAction, SpawnAction, RemoveAction, PickUpAction,
                            PutDownAction, LightAction, EnvironmentAction, CameraAction, FaultAction, ClearFaultAction,
                            UserAction>;

struct EventSpec {
    std::string name;
    Trigger when;
    std::vector<Action> actions;
    std::int64_t limit = 0;  ///< how often it fires at most; 0: any number
};

/// One event that fired.
struct EventRecord {
    std::uint64_t sequence = 0;  ///< from 1, without gaps
    TimeNs world_ns = 0;
    std::string event;
    std::string actor;                ///< who entered, left, met or arrived; empty: nobody
    std::vector<std::string> data;    ///< of its user actions, JSON text
    std::vector<std::string> errors;  ///< actions that could not be done
};

/// An event that waits to fire.
struct EventReport {
    std::string name;
    std::string when;  ///< the kind of its trigger
    std::int64_t fired = 0;
    std::int64_t limit = 0;
};

std::string_view type_name(const Trigger& trigger);

}  // namespace camrig::world
