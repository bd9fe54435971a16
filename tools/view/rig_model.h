#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include <camrig/parameters.h>
#include <nlohmann/json.hpp>

namespace camrig::view {

struct ActorRow {
    std::string name;
    std::string doing;  ///< the clip it plays, else its behaviour
    client::Vector3 position{};
};

struct EventRow {
    std::string name;
    std::string when;  ///< the kind of its trigger
    std::int64_t fired = 0;
};

struct Firing {
    std::int64_t sequence = 0;
    std::int64_t world_ns = 0;
    std::string event;
    std::string actor;  ///< who was the reason, or empty
};

/// What the rig said last; what the panels show.
struct RigModel {
    std::string problem = "connecting";  ///< empty: the rig answers
    std::string refused;                 ///< why the last edit was not done, or empty
    client::WorldStatus world = {};
    std::vector<client::CameraState> cameras = {};                       ///< without the view's own
    std::shared_ptr<const nlohmann::json> settings = {};                 ///< of all cameras, as camera.list answers
    std::shared_ptr<const std::vector<client::FaultState>> faults = {};  ///< of all cameras
    std::vector<ActorRow> actors = {};
    std::vector<EventRow> events = {};
    std::deque<Firing> firings = {};  ///< the newest last; at most max_firings

    static constexpr std::size_t max_firings = 512;
    const client::CameraState* find(const std::string& name) const {
        for (const auto& camera : cameras)
            if (camera.name == name) return &camera;
        return nullptr;
    }
};

}  // namespace camrig::view
