#include "core/world/behaviour/sequence.h"

namespace camrig::world {

void Sequence::begin(const StepContext& context, ActorState& state) {
    now_ = factory_.make(spec_.steps[index_].behaviour, actor_, true);
    began_ns_ = context.now_ns;
    began_firing_ = context.world ? context.world->last_firing() : 0;
    now_->start(context, state);
}

bool Sequence::ends(const StepContext& context) const {
    const SequenceStep& step = spec_.steps[index_];
    if (step.duration_ns && context.now_ns - began_ns_ >= *step.duration_ns) return true;
    // A firing that began this step does not end it: it was before.
    if (!step.event.empty() && context.world && context.world->last_firing(step.event) > began_firing_) return true;
    return !step.duration_ns && step.event.empty() && now_->arrived();
}

void Sequence::step(const StepContext& context, ActorState& state) {
    now_->step(context, state);
    if (done_ || !ends(context)) return;
    if (index_ + 1 == spec_.steps.size() && !spec_.repeat) {
        done_ = true;
        return;
    }
    index_ = (index_ + 1) % spec_.steps.size();
    begin(context, state);
}

void JoinRoute::step(const StepContext& context, ActorState& state) {
    now_->step(context, state);
    if (walk_ && now_->arrived()) {
        const glm::dvec3 there = state.position;
        now_ = std::move(walk_);
        now_->start(context, state);
        off_route_ = there - state.position;
        joined_ns_ = context.now_ns;
    }
    if (off_route_ == glm::dvec3(0.0)) return;
    // Smoothly, where it is steepest at the speed at which it walks.
    const double over_s = 1.5 * glm::length(off_route_) / speed_m_s_;
    const double left = 1.0 - static_cast<double>(context.now_ns - joined_ns_) * 1e-9 / over_s;
    if (left <= 0.0) {
        off_route_ = glm::dvec3(0.0);
    } else {
        state.position += left * left * (3.0 - 2.0 * left) * off_route_;
    }
}

}  // namespace camrig::world
