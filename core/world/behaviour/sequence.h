#pragma once

#include <memory>

#include "core/world/behaviour/behaviour_factory.h"

namespace camrig::world {

/// One behaviour after the other; the last one goes on. At most one change a step.
class Sequence final : public Behaviour {
public:
    Sequence(SequenceBehaviour spec, BehaviourFactory& factory, BehaviourFactory::ForActor actor)
        : spec_(std::move(spec)), factory_(factory), actor_(std::move(actor)) {}
    Sequence(const Sequence& other, BehaviourFactory& factory)
        : spec_(other.spec_),
          factory_(factory),
          actor_(other.actor_),
          index_(other.index_),
          now_(other.now_->copy(factory)),
          began_ns_(other.began_ns_),
          began_firing_(other.began_firing_),
          done_(other.done_) {}
    std::unique_ptr<Behaviour> copy(BehaviourFactory& factory) const override {
        return std::make_unique<Sequence>(*this, factory);
    }
    void add_to(Digest& digest) const override {
        now_->add_to(digest);
        digest.add(index_, began_ns_, began_firing_, done_);
    }
    void start(const StepContext& context, ActorState& state) override { begin(context, state); }
    void step(const StepContext& context, ActorState& state) override;
    bool arrived() const override { return done_; }
    bool gives_way() const override { return now_->gives_way(); }
    std::optional<Footprint> footprint() const override { return now_->footprint(); }
    const std::string* group() const override { return now_->group(); }

private:
    void begin(const StepContext& context, ActorState& state);
    bool ends(const StepContext& context) const;

    SequenceBehaviour spec_;
    BehaviourFactory& factory_;
    BehaviourFactory::ForActor actor_;
    std::size_t index_ = 0;
    std::unique_ptr<Behaviour> now_;
    TimeNs began_ns_ = 0;             ///< by the actor's clock
    std::uint64_t began_firing_ = 0;  ///< number of the latest firing then
    bool done_ = false;
};

/// Walks to where its route begins, then along it: what is left to the side and in height it loses on the way.
class JoinRoute final : public Behaviour {
public:
    JoinRoute(std::unique_ptr<Behaviour> approach, std::unique_ptr<Behaviour> walk, double speed_m_s)
        : now_(std::move(approach)), walk_(std::move(walk)), speed_m_s_(speed_m_s) {}
    JoinRoute(const JoinRoute& other, BehaviourFactory& factory)
        : now_(other.now_->copy(factory)),
          walk_(other.walk_ ? other.walk_->copy(factory) : nullptr),
          speed_m_s_(other.speed_m_s_),
          off_route_(other.off_route_),
          joined_ns_(other.joined_ns_) {}
    std::unique_ptr<Behaviour> copy(BehaviourFactory& factory) const override {
        return std::make_unique<JoinRoute>(*this, factory);
    }
    void add_to(Digest& digest) const override {
        now_->add_to(digest);
        digest.add(walk_ != nullptr, off_route_, joined_ns_);
    }
    void start(const StepContext& context, ActorState& state) override { now_->start(context, state); }
    void step(const StepContext& context, ActorState& state) override;
    bool arrived() const override { return !walk_ && now_->arrived(); }
    bool gives_way() const override { return now_->gives_way(); }

private:
    std::unique_ptr<Behaviour> now_, walk_;
    double speed_m_s_;
    glm::dvec3 off_route_{0.0};  ///< where it was when it came to the route, against it
    TimeNs joined_ns_ = 0;       ///< when that was
};

}  // namespace camrig::world
