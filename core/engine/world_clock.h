#pragma once

#include "core/base/time.h"

namespace camrig::engine {

/// How world time follows CLOCK_MONOTONIC: one to one while running, or not at all. Plain arithmetic; reads no clock.
class WorldClock {
public:
    bool running() const { return running_; }
    /// From monotonic_ns on, world time runs on from world_ns.
    void run(TimeNs world_ns, TimeNs monotonic_ns) {
        running_ = true;
        world_base_ns_ = world_ns;
        monotonic_base_ns_ = monotonic_ns;
    }
    void hold(TimeNs world_ns) {
        running_ = false;
        world_base_ns_ = world_ns;
    }
    TimeNs world_at(TimeNs monotonic_ns) const {
        return running_ ? world_base_ns_ + (monotonic_ns - monotonic_base_ns_) : world_base_ns_;
    }
    /// While running: when world_ns is reached.
    TimeNs monotonic_at(TimeNs world_ns) const { return monotonic_base_ns_ + (world_ns - world_base_ns_); }

private:
    bool running_ = false;
    TimeNs world_base_ns_ = 0;
    TimeNs monotonic_base_ns_ = 0;
};

}  // namespace camrig::engine
