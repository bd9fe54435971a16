#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "core/base/image_size.h"
#include "core/camera/intrinsics.h"
#include "core/camera/lens.h"
#include "core/camera/pose.h"

/// What a photo of a real place tells of the camera that took it and of the light there. Pixels are those of the photo,
/// centres at integers; metres are the world's, z up.
namespace camrig::photo {

/// A point whose place is known, and where the photo shows it.
struct KnownPoint {
    glm::dvec2 px{0.0};
    glm::dvec3 m{0.0};
};

/// Something upright of a known height that stands on level ground, nobody knows where.
struct KnownHeight {
    glm::dvec2 foot_px{0.0}, head_px{0.0};
    double height_m = 1.75;
    double z = 0.0;  ///< of the ground there
};

enum class Axis : std::uint8_t { x, y, z };

/// Two places on an edge that runs along an axis of the world (of a building, a kerb, a post).
struct AxisLine {
    Axis axis = Axis::z;
    glm::dvec2 from_px{0.0}, to_px{0.0};
};

/// Sides of a photo, in pixels.
inline constexpr int min_photo_side = 16, max_photo_side = 16384;

/// What is known of a photo. Without points the camera stands over the world's origin and, without lines along x or y,
/// looks along x: nothing says otherwise. Heights and the camera's own are taken as exact.
struct PlateTask {
    ImageSize size;
    std::optional<camera::Intrinsics> intrinsics{};  ///< nullopt: square pixels of a focal length that is sought
    std::optional<glm::dvec2> principal_px{};        ///< of a photo that was cropped; nullopt: its middle
    camera::Lens lens{};                             ///< known
    bool fit_k1 = false;                             ///< seeks k1 of a plumb_bob lens
    std::optional<double> click_px{};                ///< standard deviation of a click; nullopt: from the residuals
    std::optional<double> camera_height_m{};         ///< z of the camera; nullopt: sought
    std::vector<KnownPoint> points{};
    std::vector<KnownHeight> heights{};
    std::vector<AxisLine> lines{};
};

/// How far a click is from where the calibrated camera has what was clicked at.
struct PlateResidual {
    std::string of;  ///< "points[2]", "heights[0].head_px", "lines[1]"
    double px = 0.0;
    glm::dvec2 off_px{0.0};  ///< clicked minus calibrated; of a line: 0
};

/// What is uncertain: a row of the covariance.
enum class PlateUnknown : std::uint8_t { turn_x, turn_y, turn_z, x, y, z, focal, k1 };
/// "turn_x_rad" (about the world's x through the camera), .., "x_m", .., "focal_share" (of the focal length), "k1".
const char* name_of(PlateUnknown unknown);

enum class PlateGrade : std::uint8_t { good, fair, poor };
const char* name_of(PlateGrade grade);

struct PlateCalibration {
    ImageSize size;
    camera::Intrinsics intrinsics;
    camera::Lens lens;
    camera::Pose pose;
    std::vector<PlateUnknown> unknowns;
    std::vector<double> covariance;  ///< of the unknowns, row by row
    /// The 95 % region of all unknowns together: those e with e^T covariance^-1 e below this. Chi square of a stated
    /// click error, Hotelling's of one that the residuals tell.
    double region_95 = 0.0;
    /// Half widths of 95 % intervals, each by itself; 0 of what is taken as known.
    struct Halves {
        glm::dvec3 position_m{0.0};
        camera::PanTiltRoll angles;
        double focal_px = 0.0, k1 = 0.0;
    } half_95;
    int degrees_of_freedom = 0;
    double click_px = 0.0;  ///< stated, or what the residuals tell
    bool is_click_stated = false;
    double rms_px = 0.0;
    std::vector<PlateResidual> residuals;
    /// Of the height of a person in the picture, the worst of the places clicked at, or of the ground in the lower half
    /// of the photo where no place was. Nothing: nobody is seen whole there.
    std::optional<double> person_share_95;
    std::optional<double> ground_m_95;  ///< of the place of a pixel on the ground, the same; nothing: none is seen
    PlateGrade grade = PlateGrade::poor;
    std::string verdict;  ///< a sentence
};

}  // namespace camrig::photo
