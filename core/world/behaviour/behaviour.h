#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/base/digest.h"
#include "core/base/time.h"
#include "core/world/model.h"
#include "core/world/walk/crowd.h"

namespace camrig::world {

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

/// What behaviours may see of the rest of the world: how it was at the step before, so that the
/// order in which actors are stepped does not matter.
class WorldView {
public:
    virtual ~WorldView() = default;
    virtual const Crowd& crowd() const = 0;
    /// Where an actor is, also one that hangs on another; nothing: there is no such actor (any more).
    virtual std::optional<glm::dvec3> actor_position(const std::string& name) const = 0;
    /// The place of an actor among those of its group, by id.
    struct Slot {
        std::size_t index = 0;
        std::size_t count = 1;
    };
    virtual Slot group_slot(const std::string& group, std::uint32_t id) const = 0;
    /// Firings of all events are numbered from 1. 0: it has not fired.
    virtual std::uint64_t last_firing(const std::string& event) const = 0;
    /// The number of the latest firing so far.
    virtual std::uint64_t last_firing() const = 0;
};

class BehaviourFactory;

/// The step to compute, and for whom.
struct StepContext {
    TimeNs now_ns = 0;    ///< of the state to compute, by the actor's own clock: stops while the actor is held
    TimeNs step_ns = 0;   ///< length of the step that leads to it
    TimeNs world_ns = 0;  ///< of the state to compute
    std::uint64_t seed = 0;
    std::uint32_t id = 0;   ///< of the actor; its stream of random numbers
    double radius_m = 0.0;  ///< of its body
    double scale = 1.0;     ///< of the actor: a larger one takes longer steps
    const WorldView* world = nullptr;

    double step_s() const { return static_cast<double>(step_ns) * 1e-9; }
};

/// What a behaviour says of the room its actor takes.
struct Footprint {
    double length_m = 0.0;
    double width_m = 0.0;
};

/// Moves one actor.
///
/// Thread: the world's. Deterministic: the new state is a function of the context, of the state before and of what the
/// behaviour remembers itself. What can be computed from time in closed form is, so that nothing drifts.
class Behaviour {
public:
    virtual ~Behaviour() = default;
    /// Before the first step: takes over the state that the actor has at context.now_ns.
    virtual void start(const StepContext& context, ActorState& state) { step(context, state); }
    /// Turns the state of the step before into the state at context.now_ns. At most one clip, of weight 1.
    virtual void step(const StepContext& context, ActorState& state) = 0;
    /// The same with all that it remembers, in a world whose factory is this.
    virtual std::unique_ptr<Behaviour> copy(BehaviourFactory& factory) const = 0;
    /// Adds what it remembers from step to step, and what of its orders decides the next.
    virtual void add_to(Digest& digest) const = 0;
    /// Has done what it was to do. What never ends never arrives.
    virtual bool arrived() const { return false; }
    /// Avoids others by itself, so that each of two does half of the avoiding (ORCA).
    virtual bool gives_way() const { return false; }
    /// Nothing: a disc of the actor's radius.
    virtual std::optional<Footprint> footprint() const { return std::nullopt; }
    /// The group in which it stands or to which it walks; null: none.
    virtual const std::string* group() const { return nullptr; }
};

/// The clip at a clip time that may be anything: wrapped into the clip's duration, in integers.
ClipPlay clip_at(const Model& model, int animation, WideInt clip_ns, WideInt clip_ns_before);

}  // namespace camrig::world
