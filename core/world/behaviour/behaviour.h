#pragma once

#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/base/time.h"
#include "core/world/model.h"

namespace camrig {

/// Wide enough for any product of a time and a speed in nanometres.
__extension__ using WideInt = __int128;

/// A clip that an actor plays, with how far it moved during the last step: a snapshot between two steps goes back from
/// the later one by a part of that, in integers.
struct ClipPlay {
    int animation = 0;
    TimeNs duration_ns = 0;
    TimeNs phase_ns = 0;    ///< 0 <= phase < duration (0 when the duration is 0)
    TimeNs advance_ns = 0;  ///< not wrapped
    double weight = 1.0;
};

/// Everything about an actor that changes; one per actor and step.
struct ActorState {
    glm::dvec3 position{0.0};
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0};  ///< of the actor: its front is +x
    std::vector<ClipPlay> clips;
};

/// What a behaviour may know of the step it computes. Grows with what behaviours need (neighbours, regions, events).
struct StepContext {
    TimeNs now_ns = 0;   ///< world time of the state to compute; 0 for the first
    TimeNs step_ns = 0;  ///< length of the step that leads to it
    std::uint64_t seed = 0;
};

/// Moves one actor.
///
/// Thread: the world's. Deterministic: the new state is a function of the context, of the state before and of what the
/// behaviour remembers itself. What can be computed from time in closed form is, so that nothing drifts.
class Behaviour {
public:
    virtual ~Behaviour() = default;
    /// Turns the state of the step before into the state at context.now_ns.
    virtual void step(const StepContext& context, ActorState& state) = 0;
};

/// The clip at a clip time that may be anything: wrapped into the clip's duration, in integers.
ClipPlay clip_at(const Model& model, int animation, WideInt clip_ns, WideInt clip_ns_before);

}  // namespace camrig
