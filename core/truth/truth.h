#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/base/clock_reading.h"
#include "core/base/ids.h"
#include "core/base/sensor_reading.h"
#include "core/base/time.h"
#include "core/camera/pose.h"
#include "core/camera/ptz_status.h"
#include "core/fault/fault_plan.h"
#include "core/truth/keypoints.h"
#include "core/world/camera_spec.h"

namespace camrig::truth {

/// A rectangle of pixels as array slices and cv2.boundingRect have it: columns [x, x + width), rows [y, y + height).
struct PixelBox {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;
    friend bool operator==(const PixelBox&, const PixelBox&) = default;
};

/// What is true of one object in one frame. Surfaces with glTF's alpha mode BLEND (glass, soft shadows) do not count,
/// here and in the instance, semantic, depth and normal pictures.
struct ObjectTruth {
    ObjectId id{};
    std::string name;
    std::string object_class;
    std::uint32_t class_number = 0;

    std::int64_t pixels = 0;         ///< that show it
    std::int64_t pixels_soiled = 0;  ///< of `pixels`, of which dirt on the lens takes more than half of the light
    std::int64_t pixels_alone = 0;   ///< that would show it if nothing else were there; never 0
    std::optional<PixelBox> box;     ///< around `pixels`; none when all of it is hidden
    /// Around the picture of the whole object, hidden and outside parts included, in OpenCV's continuous coordinates
    /// (pixel centres at integers): what cv2.projectPoints gives of its surface.
    glm::dvec2 box_full_min{0.0};
    glm::dvec2 box_full_max{0.0};
    /// Part of it has no place in the picture plane: nearer than the near plane or behind the camera, beyond the far
    /// plane, or outside of the lens's field. box_full is that of the rest.
    bool is_clipped = false;
    double truncated = 0.0;               ///< share of box_full's area outside of the picture, 0 to 1
    std::optional<ObjectId> occluded_by;  ///< shows on most of the pixels that are hidden; none when none is

    glm::dvec3 position{0.0};                    ///< of its origin, world, m
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0};  ///< world_from_object; an actor's +x is ahead
    glm::dvec3 velocity{0.0};                    ///< m/s, world
    glm::dvec3 center{0.0};                      ///< of its 3D box, world, m
    glm::dvec3 dimensions{0.0};                  ///< of its 3D box along its own x, y, z, m
    std::vector<Keypoint> keypoints;             ///< the 17 of COCO in their order; empty without them
};

/// What of a film a frame shows.
struct FilmTruth {
    std::int64_t frame = 0;  ///< of the film, from 0
    std::int64_t late = 0;   ///< how many instants so far were shown an earlier one than theirs
};

/// The truth of one frame of one camera.
struct TruthOfFrame {
    std::string camera;
    std::int64_t sequence = 0;
    TimeNs world_ns = 0;
    TimeNs monotonic_ns = 0;
    ImageSize size;
    camera::Intrinsics intrinsics;
    camera::Lens lens;
    camera::Pose pose;                              ///< world_from_link at that instant
    std::optional<camera::Pose> believed_pose;      ///< what its calibration says, where that is not so
    std::optional<camera::PtzStatus> head;          ///< of a camera on a pan/tilt/zoom head
    std::optional<ClockReading> clock;              ///< of a camera with one of its own
    std::optional<SensorReading> sensor;            ///< of a camera with one: how the frame is taken
    fault::FrameFaultsRef faults;                   ///< of a camera that fails; null: nothing does
    std::optional<std::string_view> not_drawn;      ///< why no reader was given it: a name of stream::DropReason
    std::shared_ptr<const world::CameraSpec> spec;  ///< of the camera
    std::optional<FilmTruth> film;                  ///< of a camera with one
    std::map<std::uint32_t, std::string> classes;   ///< by number, of everything in the world
    std::vector<std::int64_t> ground;               ///< that it sees, where asked for: seen_ground()
    std::vector<ObjectTruth> objects;               ///< that the camera sees or would see alone, by rising id
};

using TruthRef = std::shared_ptr<const TruthOfFrame>;

}  // namespace camrig::truth
