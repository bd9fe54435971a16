#pragma once

#include "core/world/actor_spec.h"
#include "core/world/behaviour/walker.h"

namespace camrig::world {

/// Moves as it was told last, by a program outside (actor.steer).
class Steered final : public Behaviour {
public:
    explicit Steered(Gait::Options gait) : model_(gait.model), gait_(std::move(gait)) {}
    void start(const StepContext& context, ActorState& state) override { gait_.start(context, state); }
    void step(const StepContext& context, ActorState& state) override;
    std::unique_ptr<Behaviour> copy(BehaviourFactory&) const override { return std::make_unique<Steered>(*this); }
    void add_to(Digest& digest) const override {
        gait_.add_to(digest);
        digest.add(velocity_, to_, left_ns_, yaw_rad_);
    }
    bool arrived() const override { return !to_ && velocity_ == glm::dvec3(0.0); }

    /// From the state that the actor has now. The clip must be one of its model's.
    void steer(const SteerSpec& spec, const StepContext& context, ActorState& state);

private:
    ModelRef model_;
    Gait gait_;
    glm::dvec3 velocity_{0.0};
    std::optional<glm::dvec3> to_;
    TimeNs left_ns_ = 0;  ///< on the way there; none passes while it is carried
    std::optional<double> yaw_rad_;
};

}  // namespace camrig::world
