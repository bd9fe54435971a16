#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "core/base/image_size.h"
#include "core/base/result.h"
#include "core/camera/intrinsics.h"
#include "core/camera/lens.h"
#include "core/camera/pose.h"

namespace camrig::photo {

/// What another program says of a photo's camera.
struct KnownCamera {
    ImageSize size;
    camera::Intrinsics intrinsics;
    camera::Lens lens;
    std::optional<camera::Pose> pose;  ///< in the world of that program
};

/// Reads it. The kind is told by what is in it:
///   fSpy     JSON ("export camera parameters"): focal length, principal point, pose; no lens. z is up where the axes
///            were assigned so
///   COLMAP   text: the folder of cameras.txt and images.txt, or cameras.txt, or images.txt. `image`: its name there;
///            empty: the only one. Models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV,
///            OPENCV_FISHEYE, SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE. Its world has no metres and no up of its own:
///            points tell them
///   others   OpenCV, ROS and Kalibr, as camera::read_calibration_file: no pose
/// `size`: of the photo, if known; a file that says another is refused.
Result<KnownCamera> read_camera_file(const std::filesystem::path& file, const std::string& image,
                                     std::optional<ImageSize> size);

/// The same from the text of files by their names: cameras.txt with or without images.txt, or one other file. Messages
/// begin with the name.
Result<KnownCamera> parse_camera_files(const std::map<std::string, std::string>& texts, const std::string& image,
                                       std::optional<ImageSize> size);

/// The parts.
Result<KnownCamera> parse_fspy(const std::string& text);
Result<KnownCamera> parse_colmap(const std::string& cameras, const std::string& images, const std::string& image);

}  // namespace camrig::photo
