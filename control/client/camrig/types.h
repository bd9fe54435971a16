#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <camrig/parameters.h>
#include <camrig/values.h>

/// The values that a camera is made of, and what the world is doing. Units are SI; degrees where a name ends in _deg.
/// The world is right-handed, z up, in metres; a camera's body frame has x forward, y left, z up.
namespace camrig::client {

/// What the world is doing. Times are ns since the scene was loaded.
struct WorldStatus {
    std::string scene = {};
    std::string scene_file = {};
    std::string mode = {};      ///< realtime or lockstep
    std::string overload = {};  ///< drop or slow
    std::string quality = {};
    bool paused = false;
    std::int64_t world_ns = 0;
    std::int64_t step_ns = 0;  ///< the world's own step
    std::uint64_t seed = 0;
    std::int64_t state_ns = 0;
    std::string state_hash = {};
    int objects = 0;
    int actors = 0;
    int cameras = 0;
    std::vector<std::string> places = {};
    std::int64_t applied_ns = 0;
};

}  // namespace camrig::client
