#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/world/behaviour/behaviour.h"
#include "core/world/snapshot.h"

namespace camrig::world {

/// What an attached thing hangs on, and where.
struct Held {
    std::uint32_t carrier = 0;                          ///< id
    int node = -1;                                      ///< -1: the carrier's origin
    glm::dquat heading_from_model{1.0, 0.0, 0.0, 0.0};  ///< the carrier's
    glm::dvec3 position{0.0};
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0};
    std::string carrier_name;
};

/// A mover at one step.
struct MoverRecord {
    std::shared_ptr<const ObjectInfo> info;
    double scale = 1.0;
    glm::dquat heading_from_model{1.0, 0.0, 0.0, 0.0};
    glm::dvec3 velocity{0.0};  ///< m/s, of the step that led here
    ActorState state;
    std::optional<Held> held;
    bool is_hidden = false;
};

/// The world at one step: how the step came to its end, and what commands and events then made of it.
struct StepRecord {
    TimeNs world_ns = 0;
    std::vector<ActorState> arrived;  ///< before commands and events; movers of the step before
    std::shared_ptr<const StaticSet> statics;
    std::vector<MoverRecord> movers;  ///< in the order in which they came
};

/// Where the mover of this record is, which stands on its own.
Instance instance_of(const MoverRecord& mover);
/// `own` in its place on the carrier.
Instance hung_on(const Held& held, const Instance& carrier, Instance own, const glm::dquat& heading_from_model);

/// The last steps of a world, complete: what was at any time of their span follows from them, in whatever order it is
/// asked for. Between two steps things move as they did from one to the other; what commands and events do at once is
/// there from its step on.
class StepHistory {
public:
    /// How far back the world can be seen at least, once it has run so long.
    static constexpr TimeNs span_ns = 250 * ns_per_ms;

    /// The next step; returns memory to be used for another one.
    StepRecord push(StepRecord record);
    /// The world at `world_ns`, from the oldest record to `present`, which is newer than all here.
    SnapshotRef at(TimeNs world_ns, const StepRecord& present) const;
    /// A copy of what is needed to see every time from `world_ns` on, as far as it is kept.
    StepHistory since(TimeNs world_ns) const;
    TimeNs oldest_ns(const StepRecord& present) const {
        return records_.empty() ? present.world_ns : records_.front().world_ns;
    }

private:
    std::deque<StepRecord> records_;  ///< oldest first
};

/// The last while of a world as it was known at one instant: whatever is changed later does not change it.
/// A value; any thread.
class WorldPast {
public:
    WorldPast(StepHistory before, StepRecord present) : before_(std::move(before)), present_(std::move(present)) {}
    /// The world of that time, or of the nearest that is kept.
    SnapshotRef at(TimeNs world_ns) const;

private:
    StepHistory before_;
    StepRecord present_;
};

}  // namespace camrig::world
