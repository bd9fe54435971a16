#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/image_controls.h"
#include "core/base/image_size.h"
#include "core/base/output_spec.h"
#include "core/base/rate.h"
#include "core/base/result.h"
#include "core/camera/exposure_times.h"
#include "core/camera/intrinsics.h"
#include "core/camera/lens.h"
#include "core/camera/pose.h"
#include "core/camera/ptz_spec.h"
#include "core/sensor/sensor_spec.h"
#include "core/world/backdrop/backdrop_spec.h"
#include "core/world/camera_sampling.h"

namespace camrig::world {

struct Backdrop;

/// What a camera is fixed to: an actor, at one of its model's nodes or, without one, at its body.
struct Mount {
    std::string actor;
    std::string node;  ///< empty: the body frame
    friend bool operator==(const Mount&, const Mount&) = default;
};

enum class Quality : std::uint8_t { fast, simple, beautiful };
std::span<const Named<Quality>> names_of(std::type_identity<Quality>);

/// How the user gave the optics; kept, so that a later change of size keeps the field of view.
struct VerticalFov {
    double rad = 1.0471975511965976;  // 60 deg
    friend bool operator==(const VerticalFov&, const VerticalFov&) = default;
};
struct HorizontalFov {
    double rad = 1.0471975511965976;
    friend bool operator==(const HorizontalFov&, const HorizontalFov&) = default;
};
using Optics = std::variant<VerticalFov, HorizontalFov, camera::Intrinsics>;

/// Everything a user can say about a camera; camera_fields.cpp says what each means. Valid by construction: made by
/// patch_camera_spec only.
struct CameraSpec {
    std::string name;
    ImageSize size{640, 480};
    Rate rate;  // 25
    Optics optics = VerticalFov{};
    double zoom = 1.0;
    double optics_zoom = 1.0;       ///< the zoom that the optics were given at
    camera::Intrinsics intrinsics;  ///< derived from size, optics and zoom
    /// world_from_link; of a mounted camera frame_from_link, in the frame of its mount; of one on a head, with the head
    /// at pan and tilt 0.
    camera::Pose pose;
    std::optional<Mount> mount;
    std::optional<camera::PtzSpec> ptz;             ///< the head that turns and zooms it; nullopt: none
    std::optional<camera::ClockSpec> clock;         ///< nullopt: none of its own, it is right
    std::optional<sensor::SensorSpec> sensor;       ///< what counts the light; nullopt: light 1 is white
    std::optional<BackdropSpec> backdrop;           ///< a picture of the place; nullopt: the scene's own objects are it
    std::shared_ptr<const Backdrop> backdrop_here;  ///< derived from backdrop, size, optics, lens and pose
    camera::Lens lens;
    LensSampling lens_sampling;
    Antialias antialias = Antialias::automatic;
    double near_m = 0.05;
    double far_m = 0.0;              ///< 0: infinite
    std::optional<Quality> quality;  ///< nullopt: the rig's
    double exposure_ev = 0.0;        ///< stops more light than the scene's exposure gives; without sensor and backdrop
    ImageControls controls;
    bool code_strip = false;
    bool clock_text = false;
    std::string description;
    std::string group;  ///< cameras of one name are drawn together or dropped together; empty: on its own
    std::vector<OutputSpec> outputs;
    friend bool operator==(const CameraSpec&, const CameraSpec&) = default;
};

/// What the camera's antialias means at a level of quality; never `automatic`.
Antialias antialias_of(const CameraSpec& spec, Quality quality);

/// When the camera is due.
inline camera::ExposureTimes exposure_times_of(const CameraSpec& spec) {
    return {spec.rate, spec.clock};
}

/// What camera.create and camera.set change. Members that depend on others are named; what is empty stays as it is.
struct CameraPatch {
    std::optional<ImageSize> size = {};
    std::optional<Rate> rate = {};
    std::optional<Optics> optics = {};  ///< as they are at the zoom given with them, else at zoom 1
    std::optional<double> zoom = {};
    std::optional<camera::Pose> pose = {};
    std::optional<std::optional<Mount>> mount = {};  ///< nullopt inside: on nothing
    std::optional<double> pan_rad = {},
                          tilt_rad = {};  ///< turn the pose as a pan/tilt head does; position and roll stay
    std::optional<camera::Lens> lens = {};
    std::optional<LensSampling> lens_sampling = {};
    std::optional<std::optional<BackdropSpec>> backdrop = {};  ///< after load_backdrop(); nullopt inside: none
    std::optional<std::vector<OutputSpec>> outputs = {};
    std::vector<std::function<void(CameraSpec&)>> others = {};  ///< in this order

    void change(std::function<void(CameraSpec&)> one) { others.push_back(std::move(one)); }
};

/// A copy of `base` with the patch applied, checked as a whole; nothing changes when it fails.
Result<CameraSpec> patch_camera_spec(const CameraSpec& base, const CameraPatch& patch);

}  // namespace camrig::world
