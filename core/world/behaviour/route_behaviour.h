#pragma once

#include <memory>

#include "core/world/behaviour/behaviour.h"
#include "core/world/route_path.h"

namespace camrig::world {

/// Walks a route at constant speed. Distance is counted in whole nanometres from world time, so place and clip phase at
/// a time are exact functions of it, however long the rig runs. A clip with a ground speed advances by the distance
/// walked (feet do not slide); without one it plays in real time.
class RouteWalk final : public Behaviour {
public:
    struct Options {
        std::shared_ptr<const RoutePath> path;
        RouteBehaviour::Mode mode = RouteBehaviour::Mode::loop;
        double speed_m_s = 1.0;
        double start_m = 0.0;
        ModelRef model;
        int animation = -1;  ///< none
    };
    explicit RouteWalk(Options options);
    void start(const StepContext& context, ActorState& state) override;
    void step(const StepContext& context, ActorState& state) override;
    std::unique_ptr<Behaviour> copy(BehaviourFactory&) const override { return std::make_unique<RouteWalk>(*this); }
    void add_to(Digest& digest) const override {
        digest.add(static_cast<int>(options_.mode), length_nm_, speed_nm_s_, start_nm_, ground_speed_m_s_, origin_ns_,
                   arrived_);
    }
    bool arrived() const override { return arrived_; }
    /// Where it is at its start, and where it faces.
    RoutePath::Point begin() const { return at(start_nm_); }

private:
    /// Where it is when it has walked so far, by its mode.
    RoutePath::Point at(WideInt walked_nm) const;
    /// Whole nanometres walked since the start of the route.
    WideInt distance_nm(TimeNs now_ns) const;
    WideInt clip_ns(TimeNs now_ns, double scale) const;

    Options options_;
    std::int64_t length_nm_;
    std::int64_t speed_nm_s_;
    std::int64_t start_nm_;
    double ground_speed_m_s_ = 0.0;  ///< of the clip; 0: real time
    TimeNs origin_ns_ = 0;           ///< when it was at its start
    bool arrived_ = false;           ///< mode once: stands at the end
};

}  // namespace camrig::world
