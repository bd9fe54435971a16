#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/base/image_size.h"
#include "core/base/result.h"
#include "core/camera/intrinsics.h"
#include "core/camera/lens.h"

namespace camrig::camera {

/// What a calibration says about one camera.
struct Calibration {
    std::string camera_name;  ///< as the file gives it, may be empty
    ImageSize size;
    Intrinsics intrinsics;
    Lens lens;
    friend bool operator==(const Calibration&, const Calibration&) = default;
};

/// What the reader of a calibration already knows.
struct CalibrationQuery {
    /// Which camera of a file that holds several (Kalibr: "cam0" or a rostopic; OpenCV stereo: "1" or "2"); empty: the
    /// only one.
    std::string camera;
    /// The size of the picture, if known: needed for files that do not say it, and a file that says another is refused.
    std::optional<ImageSize> size;
};

/// Reads the calibration of a real camera. The flavour is recognised by its keys:
///   ROS camera_info YAML   image_width, camera_matrix, distortion_model: plumb_bob | rational_polynomial | equidistant
///   OpenCV FileStorage     YAML or JSON; camera_matrix | cameraMatrix | K | M1 and distortion_coefficients |
///   distCoeffs
///                          | D | D1 with 4, 5, 8, 12 or 14 numbers (beyond the eighth all zero); `fisheye_model: 1`
///                          makes 4 of them an equidistant lens. FileStorage XML is not read.
///   Kalibr camchain        camN with camera_model pinhole and distortion_model radtan | equidistant | none
/// The whole camera is checked (CameraModel::create), so what comes back can be used. Errors name the file, the key and
/// what would be right. The file is untrusted: see yaml_document.h for the bounds.
Result<Calibration> read_calibration_file(const std::string& path, const CalibrationQuery& query = {});
/// The same from text; `source` names it in messages.
Result<Calibration> parse_calibration(std::string_view text, std::string_view source,
                                      const CalibrationQuery& query = {});

/// ROS camera_info YAML as camera_calibration_parsers reads it: what a ROS driver looks for as
/// $ROS_HOME/camera_info/<name>.yaml. A pinhole is written as plumb_bob with zeros (ROS has no name for it).
/// Rectification is the identity and the projection matrix that of the camera itself (a monocular camera). Numbers are
/// written so that they come back exactly. `camera_name` must be [A-Za-z0-9_]+.
Result<std::string> write_camera_info(const Calibration& calibration);

}  // namespace camrig::camera
