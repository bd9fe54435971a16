#pragma once

#include <memory>

#include "core/base/result.h"
#include "core/world/scene.h"
#include "core/world/snapshot.h"

namespace camrig {

/// The world: objects, actors and their behaviours, advanced in fixed steps of its own.
///
/// Thread: the engine's. Cameras sample it between steps by interpolation, so they never change what happens in it.
/// Deterministic: the state after step k is a pure function of scene, seed and the commands applied before it.
class World {
public:
    static Result<std::unique_ptr<World>> create(SceneRef scene, std::uint64_t seed);
    virtual ~World() = default;

    virtual const Scene& scene() const = 0;
    /// Runs steps until the last one is at or after `world_ns`. Never goes back.
    virtual void advance_to(TimeNs world_ns) = 0;
    /// The world at `world_ns`, which must lie between the last two steps (advance_to(world_ns) makes it so).
    virtual SnapshotRef snapshot(TimeNs world_ns) const = 0;
};

}  // namespace camrig
