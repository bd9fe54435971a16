#pragma once

#include <nlohmann/json.hpp>

#include "core/base/json_reader.h"
#include "core/photo/calibrate_plate.h"
#include "core/photo/camera_file.h"
#include "core/photo/plate_light.h"
#include "core/photo/plate_view.h"

/// How the command line and the control protocol write what core/photo takes and gives (docs/backdrops.md, "Calibrating
/// a photo").
namespace camrig::photo {

/// Reads size, points, heights, lines, intrinsics | vfov_deg, principal_px, lens, fit_k1, click_px, camera_height_m.
/// `size` and `known` are what is known already, of the photo and of a file of its camera.
PlateTask read_plate_task(JsonReader& reader, std::optional<ImageSize> size, const std::optional<KnownCamera>& known);

/// Reads camera_files (an object from file names to their text) and camera_image; nullopt: none were given, or the
/// error is in the reader. `size` beside them is the photo's.
std::optional<KnownCamera> read_known_camera(JsonReader& reader);

/// All that was found, angles in degrees, and as `ground` what ground_json says.
nlohmann::json to_json(const PlateCalibration& found);

/// calibrate_plate or, where there is nothing to calibrate from but a file that has a pose, what that says: camera,
/// verdict (`unknown`), reason and ground.
Result<nlohmann::json> calibration_json(const PlateTask& task, const std::optional<KnownCamera>& known);

/// `ground` of a backdrop's proxies: the part of the photo below its horizon, as far as people are worth looking at;
/// null where the camera sees no ground.
nlohmann::json ground_json(const PlateView& view, ImageSize size);

/// `size`, `intrinsics`, `lens`, `pose` of a camera as scene files and camera.create have them.
nlohmann::json camera_json(ImageSize size, const camera::Intrinsics& k, const camera::Lens& lens,
                           const camera::Pose& pose);

/// Where the sun stands, and it and the sky as `lights` and `environment` of scenes. north: of photo::light_direction.
nlohmann::json light_json(const PlateLight& light, const glm::dvec3& direction, double north);

/// Such a camera as a view; the error has its path.
Result<PlateView> read_camera(const nlohmann::json& json, const std::string& path, ImageSize* size);

}  // namespace camrig::photo
