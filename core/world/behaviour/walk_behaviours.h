#pragma once

#include <string>

#include "core/world/behaviour/walker.h"
#include "core/world/behaviour_spec.h"

/// Behaviours of those who find their way themselves. Each is a Walker and where it wants to go.
namespace camrig::world {

class GoTo final : public Behaviour {
public:
    GoTo(Walker walker, const glm::dvec2& goal, std::optional<double> yaw_rad)
        : walker_(std::move(walker)), goal_(goal), yaw_rad_(yaw_rad) {}
    void start(const StepContext& context, ActorState& state) override { walker_.start(context, state); }
    void step(const StepContext& context, ActorState& state) override {
        walker_.step_to(context, goal_, yaw_rad_, state);
    }
    std::unique_ptr<Behaviour> copy(BehaviourFactory&) const override { return std::make_unique<GoTo>(*this); }
    void add_to(Digest& digest) const override {
        walker_.add_to(digest);
        digest.add(goal_, yaw_rad_);
    }
    bool arrived() const override { return walker_.arrived(); }
    bool gives_way() const override { return true; }

private:
    Walker walker_;
    glm::dvec2 goal_;
    std::optional<double> yaw_rad_;
};

class Wander final : public Behaviour {
public:
    Wander(Walker walker, std::shared_ptr<const WalkArea> area, double pause_s)
        : walker_(std::move(walker)), area_(std::move(area)), pause_s_(pause_s) {}
    void start(const StepContext& context, ActorState& state) override { walker_.start(context, state); }
    void step(const StepContext& context, ActorState& state) override;
    std::unique_ptr<Behaviour> copy(BehaviourFactory&) const override { return std::make_unique<Wander>(*this); }
    void add_to(Digest& digest) const override {
        walker_.add_to(digest);
        digest.add(pause_s_, goal_, has_goal_, pause_until_ns_, draws_);
    }
    bool gives_way() const override { return true; }

private:
    void choose_goal(const StepContext& context, const glm::dvec2& at);

    Walker walker_;
    std::shared_ptr<const WalkArea> area_;
    double pause_s_;
    glm::dvec2 goal_{0.0};
    bool has_goal_ = false;
    TimeNs pause_until_ns_ = 0;
    std::uint64_t draws_ = 0;
};

class Follow final : public Behaviour {
public:
    Follow(Walker walker, std::string actor, double distance_m)
        : walker_(std::move(walker)), actor_(std::move(actor)), distance_m_(distance_m) {}
    void start(const StepContext& context, ActorState& state) override { walker_.start(context, state); }
    void step(const StepContext& context, ActorState& state) override;
    std::unique_ptr<Behaviour> copy(BehaviourFactory&) const override { return std::make_unique<Follow>(*this); }
    void add_to(Digest& digest) const override {
        walker_.add_to(digest);
        digest.add(actor_, distance_m_, is_near_);
    }
    bool gives_way() const override { return true; }

private:
    Walker walker_;
    std::string actor_;
    double distance_m_;
    bool is_near_ = false;
};

class Grouped final : public Behaviour {
public:
    Grouped(Walker walker, const GroupBehaviour& group) : walker_(std::move(walker)), group_(group) {}
    void start(const StepContext& context, ActorState& state) override { walker_.start(context, state); }
    void step(const StepContext& context, ActorState& state) override;
    std::unique_ptr<Behaviour> copy(BehaviourFactory&) const override { return std::make_unique<Grouped>(*this); }
    void add_to(Digest& digest) const override {
        walker_.add_to(digest);
        digest.add(group_.group, group_.position, group_.radius_m);
    }
    bool arrived() const override { return walker_.arrived(); }
    bool gives_way() const override { return true; }
    const std::string* group() const override { return &group_.group; }

private:
    Walker walker_;
    GroupBehaviour group_;
};

/// Stays on its spot and turns towards somebody or something.
class LookAt final : public Behaviour {
public:
    LookAt(Gait gait, std::string actor, const glm::dvec2& point)
        : gait_(std::move(gait)), actor_(std::move(actor)), point_(point) {}
    void start(const StepContext& context, ActorState& state) override { gait_.start(context, state); }
    void step(const StepContext& context, ActorState& state) override;
    std::unique_ptr<Behaviour> copy(BehaviourFactory&) const override { return std::make_unique<LookAt>(*this); }
    void add_to(Digest& digest) const override {
        gait_.add_to(digest);
        digest.add(actor_, point_, faces_);
    }
    bool arrived() const override { return faces_; }

private:
    Gait gait_;
    std::string actor_;
    glm::dvec2 point_;
    bool faces_ = false;
};

}  // namespace camrig::world
