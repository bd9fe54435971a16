#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/world/behaviour/behaviour.h"
#include "core/world/turn.h"
#include "core/world/walk/velocity_choice.h"
#include "core/world/walk/walk_area.h"

namespace camrig::world {

/// The clips of somebody who walks and stands: the walking clip advances by the ground covered, so that feet do not
/// slide at any speed; the other plays in real time.
class Gait {
public:
    struct Options {
        ModelRef model;
        int clip = -1;       ///< none
        int idle_clip = -1;  ///< none
    };
    explicit Gait(Options options) : options_(std::move(options)) {}
    /// Everybody idles with a phase of his own.
    void start(const StepContext& context, ActorState& state);
    void step(const StepContext& context, double moved_m, ActorState& state);
    void add_to(Digest& digest) const {
        digest.add(options_.clip, options_.idle_clip, walk_ns_, idle_from_ns_, walks_);
    }

private:
    void show(const StepContext& context, ActorState& state, TimeNs walked_ns, TimeNs idled_ns) const;

    Options options_;
    TimeNs walk_ns_ = 0;       ///< clip time; bounded by the life of a world
    TimeNs idle_from_ns_ = 0;  ///< by the actor's clock, as who is carried plays on by it
    bool walks_ = false;
};

/// Walks towards a goal: along a way round the walls of its area, round other bodies (ORCA, walk/velocity_choice.h),
/// with smooth turns.
class Walker {
public:
    struct Options {
        std::shared_ptr<const WalkArea> area;  ///< null: open ground
        double speed_m_s = 1.3;
        Gait::Options gait;
    };
    explicit Walker(Options options) : options_(std::move(options)), gait_(options_.gait) {}

    void start(const StepContext& context, ActorState& state);
    /// One step on the way to `goal`. `face_rad`: where to turn when it is there.
    void step_to(const StepContext& context, const glm::dvec2& goal, std::optional<double> face_rad, ActorState& state);
    /// One step on the spot (and out of others' way).
    void step_still(const StepContext& context, std::optional<double> face_rad, ActorState& state);

    void add_to(Digest& digest) const {
        gait_.add_to(digest);
        digest.add(options_.speed_m_s, velocity_, yaw_rad_, goal_, way_.size(), best_left_m_, best_at_ns_, arrived_,
                   is_stuck_);
        for (const glm::dvec2& corner : way_) digest.add(corner);
    }
    /// At the goal of the last step_to, or as near as others let it.
    bool arrived() const { return arrived_; }
    /// Has not come nearer to its goal for a while.
    bool is_stuck() const { return is_stuck_; }

private:
    glm::dvec2 way_velocity(const StepContext& context, const glm::dvec2& at, const glm::dvec2& goal);
    void move(const StepContext& context, const glm::dvec2& wanted, std::optional<double> face_rad, ActorState& state);
    void watch_progress(const StepContext& context, double left_m);

    Options options_;
    Gait gait_;
    glm::dvec2 velocity_{0.0};
    double yaw_rad_ = 0.0;
    std::optional<glm::dvec2> goal_;
    std::vector<glm::dvec2> way_;  ///< corners still to come, the next one last
    double best_left_m_ = 0.0;     ///< nearest that it was to the goal
    TimeNs best_at_ns_ = 0;
    bool arrived_ = false;
    bool is_stuck_ = false;
    // Kept from step to step, so that a step allocates nothing.
    std::vector<const Body*> others_;
    std::vector<glm::dvec2> walls_;
    std::vector<HalfPlane> planes_;
};

}  // namespace camrig::world
