#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/world/actor_spec.h"
#include "core/world/behaviour/behaviour.h"
#include "core/world/step_history.h"

namespace camrig::world {

/// Something that moves: an actor, an object that plays a clip, or one that somebody has picked up. Thread: the
/// world's.
struct Mover {
    std::shared_ptr<const ObjectInfo> info;
    std::string model;      ///< its name in the scene
    bool is_actor = false;  ///< else an object
    BehaviourSpec spec;
    /// Of one mover alone: a copy has none until it is given one (Behaviour::copy).
    struct OwnBehaviour : std::unique_ptr<Behaviour> {
        using std::unique_ptr<Behaviour>::unique_ptr;
        using std::unique_ptr<Behaviour>::operator=;
        OwnBehaviour() = default;
        OwnBehaviour(const OwnBehaviour&) : std::unique_ptr<Behaviour>() {}
    } behaviour;
    glm::dquat heading_from_model{1.0, 0.0, 0.0, 0.0};
    double scale = 1.0;
    std::optional<std::uint64_t> variant;
    double radius_m = 0.0;

    ActorState before, now;
    bool is_hidden = false;    ///< nobody sees it
    bool is_gone = false;      ///< removed in this step
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

    std::optional<Held> held;  ///< else it stands on its own

    std::uint32_t id() const { return static_cast<std::uint32_t>(info->id); }
    glm::dvec3 velocity(TimeNs step_ns) const {
        return (now.position - before.position) / (static_cast<double>(step_ns) * 1e-9);
    }

    void start(const StepContext& context);
    /// From now on it plays the clip of this state, as a behaviour left it.
    void take_clip(const ActorState& state);
    void step(const StepContext& context);
    /// Changes `now` without a movement: no velocity follows from it, and nothing is interpolated up to it.
    template <typename Change>
    void jump(Change&& change) {
        change(now);
        before = now;
    }
    /// As it is now, after so long a step; in memory that may hold another.
    void record(TimeNs step_ns, MoverRecord& record) const;
    MoverRecord record(TimeNs step_ns) const;
    /// As it was at the step before.
    MoverRecord record_before() const;
    /// Adds all that decides how it goes on.
    void add_to(Digest& digest) const;
    /// What others see of it; nothing when it takes no room.
    std::optional<Body> body(TimeNs step_ns) const;

private:
    void play_on(TimeNs step_ns);
    void choose_clips(const StepContext& context);

    std::optional<ClipPlay> own_;     ///< of the behaviour, whatever is played over it
    ClipPlay main_{.animation = -1};  ///< the clip of the last step
    std::optional<ClipPlay> fading_;  ///< the one before it, while it fades out
    TimeNs fade_ns_ = 0;              ///< since the change
    bool has_clip_ = false;
};

}  // namespace camrig::world
