#pragma once

#include "core/world/behaviour/behaviour.h"

namespace camrig {

/// Stays where it is and plays a clip in real time, or none (animation < 0). Also moves objects that have a clip.
class Standing final : public Behaviour {
public:
    Standing(ModelRef model, int animation, const glm::dvec3& position, const glm::dquat& orientation)
        : model_(std::move(model)), animation_(animation), position_(position), orientation_(orientation) {}
    void step(const StepContext& context, ActorState& state) override {
        state.position = position_;
        state.orientation = orientation_;
        state.clips.clear();
        if (animation_ >= 0)
            state.clips.push_back(clip_at(*model_, animation_, context.now_ns, context.now_ns - context.step_ns));
    }

private:
    ModelRef model_;
    int animation_;
    glm::dvec3 position_;
    glm::dquat orientation_;
};

}  // namespace camrig
