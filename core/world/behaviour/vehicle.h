#pragma once

#include <memory>

#include "core/world/behaviour/behaviour.h"
#include "core/world/behaviour_spec.h"
#include "core/world/route_path.h"

namespace camrig::world {

/// Drives along a route and keeps its distance from whatever is on the lane ahead, vehicles and people.
///
/// Acceleration: the intelligent driver model (IDM; Treiber, Hennecke, Helbing, "Congested traffic states in empirical
/// observations and microscopic simulations", Phys. Rev. E 62, 2000): a * (1 - (v/v0)^4 - (s*/s)^2) with
/// s* = s0 + v T + v dv / (2 sqrt(a b)). On an open route it stops at the end.
class Vehicle final : public Behaviour {
public:
    struct Options {
        std::shared_ptr<const RoutePath> path;
        bool closed = false;
        VehicleBehaviour spec;
        ModelRef model;
        int animation = -1;  ///< none; with a ground speed (of the wheels' rims) it advances by the distance driven
        bool joins = false;  ///< from where it is, at the speed it has, onto the nearest point of the route
    };
    explicit Vehicle(Options options) : options_(std::move(options)) {}
    void start(const StepContext& context, ActorState& state) override;
    void step(const StepContext& context, ActorState& state) override;
    std::unique_ptr<Behaviour> copy(BehaviourFactory&) const override { return std::make_unique<Vehicle>(*this); }
    void add_to(Digest& digest) const override {
        digest.add(options_.spec.speed_m_s, options_.closed, at_m_, speed_m_s_, joining_m_, join_over_m_, off_route_,
                   off_heading_rad_, clip_ns_, arrived_);
    }
    bool arrived() const override { return arrived_; }
    std::optional<Footprint> footprint() const override {
        return Footprint{options_.spec.length_m, options_.spec.width_m};
    }

private:
    struct Leader {
        double gap_m = 0.0;
        double speed_m_s = 0.0;  ///< along the lane
    };
    std::optional<Leader> find_leader(const StepContext& context, double ahead_m);
    double wrapped(double at_m) const;
    void join(const StepContext& context, const ActorState& state);
    void place(const StepContext& context, double moved_m, ActorState& state);

    Options options_;
    double at_m_ = 0.0;  ///< of its middle
    double speed_m_s_ = 0.0;
    double joining_m_ = 0.0;  ///< so far it still drives until it is on the route
    double join_over_m_ = 1.0;
    glm::dvec3 off_route_{0.0};  ///< where it was when it began to join, against the route
    double off_heading_rad_ = 0.0;
    TimeNs clip_ns_ = 0;
    bool arrived_ = false;
    std::vector<const Body*> others_;
};

}  // namespace camrig::world
