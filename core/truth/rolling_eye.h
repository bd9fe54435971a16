#pragma once

#include <array>
#include <memory>

#include <glm/glm.hpp>

#include "core/camera/camera_model.h"
#include "core/world/camera_past.h"

namespace camrig::truth {

/// Of a picture whose rows show one time after the other: where camera and world were.
struct RowsInTime {
    std::shared_ptr<const world::CameraPast> past;
    TimeNs first_ns = 0;  ///< what the first row shows
    TimeNs row_ns = 0;
};

/// Where points of the world are for the camera at the time of the row that shows them.
class RollingEye {
public:
    /// `camera` must outlive it.
    RollingEye(const RowsInTime& rows, const camera::CameraModel& camera);

    const world::Snapshot& first() const { return *first_; }
    const world::Snapshot& last() const { return *last_; }

    /// In the optical frame of that time, as large as the camera's own focal length shows it, of a point that goes
    /// straight from one place to another from the first row to the last. Each step leaves the share of the error that
    /// the picture moves while a row is read.
    glm::dvec3 see(const glm::dvec3& from, const glm::dvec3& to) const;

private:
    static constexpr int steps = 4;
    struct Knot {
        glm::dmat3 optical_from_world{1.0};
        glm::dvec3 eye{0.0};
        double zoom = 1.0;  ///< focal length, of the camera's: a pinhole's zoom goes on while rows are read
        glm::dvec3 see(const glm::dvec3& point) const {
            return glm::dvec3(zoom, zoom, 1.0) * (optical_from_world * (point - eye));
        }
    };
    glm::dvec3 at(double share, const glm::dvec3& from, const glm::dvec3& to) const;

    const camera::CameraModel& camera_;
    std::array<Knot, 65> knots_;  ///< as is linear enough between: half a degree of a pan of 300 deg/s in 0.1 s
    world::SnapshotRef first_, last_;
};

}  // namespace camrig::truth
