#pragma once

#include <functional>
#include <string>

#include <nlohmann/json.hpp>

#include "core/base/json_reader.h"
#include "core/world/camera_spec.h"

namespace camrig {

/// Reads the camera fields of the contract (size, fps, vfov_deg | hfov_deg | intrinsics, zoom, pose, mount, lens,
/// antialias, near, far, quality, controls, code_strip, outputs) from an object whose other keys (name, place) the
/// caller reads. Errors carry the JSON path. The same reader serves camera.create, camera.set, scene files and camera
/// files. What camera.get answers is read back: redundant angles are taken where they agree, quality null is the rig's,
/// and what says how the camera lives (id, sequence, readers, applied_ns, world_pose) does nothing.
CameraPatch read_camera_patch(JsonReader& reader);

/// The camera as camera.get shows it: every field of the contract, with pose given as position, orientation and angles,
/// and the derived intrinsics and fields of view.
nlohmann::json camera_to_json(const CameraSpec& spec);

/// {"position": [..], one of "look_at" | "pan_deg","tilt_deg","roll_deg" | "orientation"}; orientation and angles
/// together only when they are the same direction.
Result<Pose> read_pose(const nlohmann::json& value, std::string path);
nlohmann::json pose_to_json(const Pose& pose);
/// {"model": .., "coefficients": [..]}, as many as the model has.
nlohmann::json lens_to_json(const Lens& lens);

}  // namespace camrig
