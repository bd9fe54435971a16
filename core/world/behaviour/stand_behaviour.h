#pragma once

#include "core/world/behaviour/behaviour.h"

namespace camrig::world {

/// Stays where it is and plays a clip in real time, or none (animation < 0). Also moves objects that have a clip.
class Standing final : public Behaviour {
public:
    Standing(ModelRef model, int animation) : model_(std::move(model)), animation_(animation) {}
    void step(const StepContext& context, ActorState& state) override {
        state.clips.clear();
        if (animation_ >= 0)
            state.clips.push_back(clip_at(*model_, animation_, context.now_ns, context.now_ns - context.step_ns));
    }
    std::unique_ptr<Behaviour> copy(BehaviourFactory&) const override { return std::make_unique<Standing>(*this); }
    void add_to(Digest& digest) const override { digest.add(animation_); }
    bool arrived() const override { return true; }

private:
    ModelRef model_;
    int animation_;
};

}  // namespace camrig::world
