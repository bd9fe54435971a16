#pragma once

#include "core/engine/rig_state.h"
#include "core/engine/world_desk.h"

namespace camrig::engine {

/// Carries out the commands for rigs that run the same world on several machines (docs/farm.md): how far and by which
/// clock this one runs, and hashes of its state to compare. Engine's thread.
class ReplicaDesk {
public:
    ReplicaDesk(RigState& state, WorldDesk& world) : state_(state), world_(world) {}

    Result<SetLimit::Reply> run(SetLimit& command);
    Result<GetDigest::Reply> run(GetDigest& command);

private:
    void set_clock(TimeNs world_ns, TimeNs monotonic_ns);

    RigState& state_;
    WorldDesk& world_;
    TimeNs clock_set_ns_ = 0;  ///< CLOCK_MONOTONIC time at which SetLimit::clock_ns came last
};

}  // namespace camrig::engine
