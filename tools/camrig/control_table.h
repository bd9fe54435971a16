#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/world/camera.h"
#include "v4l2_sink/preload/control_port.h"

/// The V4L2 controls that cameras have, and what each is of a camera.
namespace camrig::cli {

/// Settings of a sensor that stand aside while their automatic is on; they come back when it is switched off.
struct ManualSensor {
    double exposure_s = 0.01;
    double white_balance_k = 6500.0;
};

/// What the latest answer told of a camera.
struct KnownCamera {
    world::Camera camera;
    std::optional<camera::PtzStatus> head;  ///< as it was then
    ManualSensor manual = {};
};

/// What values of controls come to: a change of the camera, and moves of its head, if it has one.
struct ControlChange {
    ManualSensor manual = {};  ///< of its sensor
    std::optional<world::CameraPatch> patch;
    std::optional<camera::PtzMove> turn;   ///< absolute
    std::optional<camera::PtzMove> drive;  ///< continuous

    world::CameraPatch& camera() { return patch ? *patch : patch.emplace(); }
    camera::PtzMove& to() { return turn ? *turn : turn.emplace(); }
    camera::PtzMove& at_speed() {
        return drive ? *drive : drive.emplace(camera::PtzMove{.mode = camera::PtzMode::continuous});
    }
};

/// One control: how it is listed, and how it is read from and written to a camera.
struct CameraControl {
    device::DeviceControl control;
    std::int32_t (*read)(const KnownCamera& known);
    void (*write)(std::int32_t value, const KnownCamera& known, ControlChange& change);
    /// Of cameras on heads alone: the ends of its range.
    std::pair<std::int32_t, std::int32_t> (*range_on)(const camera::PtzSpec& head) = nullptr;
    /// Of cameras on heads alone: its value at a position.
    std::int32_t (*at)(const camera::PtzPosition& position) = nullptr;
    bool is_of_heads = false;  ///< other cameras do not have it
    /// Of cameras with a sensor alone: the ends of its range.
    std::optional<std::pair<std::int32_t, std::int32_t>> range_of_sensors = {};
    bool is_of_sensors = false;  ///< other cameras do not have it
};

const std::vector<CameraControl>& camera_controls();
/// Null: there is none of this number.
const CameraControl* find_control(std::uint32_t id);
bool has_control(const CameraControl& one, const KnownCamera* known);
/// As a program is told it; `known` may be null.
device::DeviceControl listed_for(const CameraControl& one, const KnownCamera* known);
std::int32_t read_control(const CameraControl& one, const KnownCamera& known);

/// Null: the camera is on none.
const camera::PtzHead* head_of(const KnownCamera& known);
/// Null: the camera has none.
const sensor::SensorSpec* sensor_of(const KnownCamera& known);

}  // namespace camrig::cli
