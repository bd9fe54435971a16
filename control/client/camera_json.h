#pragma once

#include <camrig/parameters.h>
#include <nlohmann/json.hpp>

namespace camrig::client {

/// Parameters of camera.create and camera.set: only what is given.
nlohmann::json params_of(const CameraOptions& options);
/// What camera.get answers. Error internal when it is not as expected; members that this client does not know are
/// passed over.
CameraState camera_state_of(const nlohmann::json& answer);
/// What world.status answers, likewise.
WorldStatus world_status_of(const nlohmann::json& answer);

}  // namespace camrig::client
