#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/world/actor_spec.h"
#include "core/world/behaviour/behaviour.h"
#include "core/world/snapshot.h"

namespace camrig {

/// Something that moves: an actor, an object that plays a clip, or one that somebody has picked up. Thread: the
/// world's.
struct Mover {
    std::shared_ptr<const ObjectInfo> info;
    std::string model;      ///< its name in the scene
    bool is_actor = false;  ///< else an object
    BehaviourSpec spec;
    std::unique_ptr<Behaviour> behaviour;
    glm::dquat heading_from_model{1.0, 0.0, 0.0, 0.0};
    double scale = 1.0;
    double radius_m = 0.0;

    ActorState before, now;
    /// The last step as it was, when something has changed `now` at once since: snapshots from before that moment still
    /// show it.
    struct LastStep {
        ActorState before, now;
    };
    std::optional<LastStep> left;
    TimeNs born_ns = 0;
    std::optional<TimeNs> gone_ns;
    bool was_arrived = false;  ///< for the events

    /// Its own clock stands still while it is held.
    TimeNs behind_ns = 0;
    std::optional<TimeNs> held_at_ns;
    /// A clip over the one of the behaviour.
    struct Played {
        int animation = -1;  ///< none: the rest pose
        std::int64_t speed_ppm = 1'000'000;
        TimeNs began_ns = 0;
        std::optional<TimeNs> until_ns;
    };
    std::optional<Played> played;

    struct Held {
        std::uint32_t carrier = 0;                          ///< id
        int node = -1;                                      ///< -1: the carrier's origin
        glm::dquat heading_from_model{1.0, 0.0, 0.0, 0.0};  ///< the carrier's
        glm::dvec3 position{0.0};
        glm::dquat orientation{1.0, 0.0, 0.0, 0.0};
        std::string carrier_name;
    };
    std::optional<Held> held;
    /// On what it hung until `held_since_ns`, when that has changed: snapshots from before that moment still show it.
    std::optional<Held> held_before;
    TimeNs held_since_ns = 0;

    std::uint32_t id() const { return static_cast<std::uint32_t>(info->id); }
    glm::dvec3 velocity(TimeNs step_ns) const {
        return (now.position - before.position) / (static_cast<double>(step_ns) * 1e-9);
    }

    void start(const StepContext& context);
    void step(const StepContext& context);
    /// `change` is made to `now` at once; it leaves no trace of a movement.
    template <typename Change>
    void jump(Change&& change) {
        if (!left) left = LastStep{before, now};
        change(now);
        before = now;
    }
    /// From now_ns, the last step, on it hangs on this; nothing: it stands on its own.
    void hang(std::optional<Held> on, TimeNs now_ns);
    const std::optional<Held>& held_at(TimeNs world_ns) const { return world_ns < held_since_ns ? held_before : held; }
    /// At the step before the last.
    Instance instance_before() const;
    /// Between the last two steps; `remaining_ns` of the last one are still to come.
    Instance instance_at(TimeNs remaining_ns, TimeNs step_ns) const;
    /// What others see of it; nothing when it takes no room.
    std::optional<Body> body(TimeNs step_ns) const;

private:
    void choose_clips(const StepContext& context);

    ClipPlay main_{.animation = -1};  ///< the clip of the last step
    std::optional<ClipPlay> fading_;  ///< the one before it, while it fades out
    TimeNs fade_ns_ = 0;              ///< since the change
    bool has_clip_ = false;
};

}  // namespace camrig
