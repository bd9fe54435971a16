#pragma once

#include <functional>
#include <string>

#include <nlohmann/json.hpp>

#include "core/base/json_reader.h"
#include "core/camera/ptz_status.h"
#include "core/world/camera_spec.h"

namespace camrig::world {

/// Reads the fields of camera_fields() from an object whose other keys (name, place) the caller reads. Errors carry the
/// JSON path. The same reader serves camera.create, camera.set, scene files and camera files. What camera.get answers
/// is read back: redundant angles are taken where they agree, and what only the rig says does nothing.
CameraPatch read_camera_patch(JsonReader& reader);

/// The camera as camera.get shows it, without what the rig adds of its life.
nlohmann::json camera_to_json(const CameraSpec& spec);

/// Entries of the table with a form of their own.
void read_size(JsonReader& reader, CameraPatch& patch);
void read_rate(JsonReader& reader, CameraPatch& patch);
/// vfov_deg, hfov_deg and intrinsics.
void read_optics(JsonReader& reader, CameraPatch& patch);
void read_lens(JsonReader& reader, CameraPatch& patch);

/// {"position": [..], one of "look_at" | "pan_deg","tilt_deg","roll_deg" | "orientation"}; orientation and angles
/// together only when they are the same direction.
Result<camera::Pose> read_pose(const nlohmann::json& value, std::string path);
nlohmann::json pose_to_json(const camera::Pose& pose);
/// {"model": .., "coefficients": [..]}, as many as the model has.
Result<camera::Lens> read_lens_model(const nlohmann::json& value, std::string path);
nlohmann::json lens_to_json(const camera::Lens& lens);
nlohmann::json ptz_to_json(const camera::PtzPosition& position);
/// Where the head believes to be, and under `true` where it is.
nlohmann::json ptz_to_json(const camera::PtzStatus& status);

}  // namespace camrig::world
