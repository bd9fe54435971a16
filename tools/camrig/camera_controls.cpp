#include "tools/camrig/camera_controls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <type_traits>

#include <linux/videodev2.h>

namespace camrig::cli {
namespace {

constexpr double arcsec_per_rad = 180.0 * 3600.0 / std::numbers::pi;
constexpr int manual_exposure = V4L2_EXPOSURE_MANUAL, scene_exposure = V4L2_EXPOSURE_APERTURE_PRIORITY;
/// exposure_absolute (in 0.1 ms) that stands for the scene's own exposure.
constexpr double usual_exposure = 100;

std::int32_t whole(double value) {
    return static_cast<std::int32_t>(std::lround(value));
}

/// One control: how it is listed, and how it is read from and written to a camera.
struct CameraControl {
    device::DeviceControl control;
    std::int32_t (*read)(const world::CameraSpec& spec);
    void (*write)(std::int32_t value, world::CameraPatch& patch);
};

/// One that stands for a member of the camera's image controls, in steps of 1 / steps_per_unit.
template <auto member, int steps_per_unit = 1>
CameraControl image_control(device::DeviceControl control) {
    return {std::move(control),
            [](const world::CameraSpec& spec) {
                return whole(static_cast<double>(spec.controls.*member) * steps_per_unit);
            },
            [](std::int32_t value, world::CameraPatch& patch) {
                patch.change([value](world::CameraSpec& spec) {
                    using Member = std::remove_reference_t<decltype(spec.controls.*member)>;
                    spec.controls.*member = static_cast<Member>(value / double{steps_per_unit});
                });
            }};
}

// The names are those of the kernel's uvcvideo of old, which usb_cam and many scripts go by.
const std::vector<CameraControl>& camera_controls() {
    using enum device::DeviceControl::Kind;
    static const std::vector<CameraControl> all{
        image_control<&ImageControls::brightness, 100>(
            {V4L2_CID_BRIGHTNESS, integer, "Brightness", -100, 100, 1, 0, 0, {}}),
        image_control<&ImageControls::contrast, 100>({V4L2_CID_CONTRAST, integer, "Contrast", 0, 200, 1, 100, 0, {}}),
        image_control<&ImageControls::saturation, 100>(
            {V4L2_CID_SATURATION, integer, "Saturation", 0, 200, 1, 100, 0, {}}),
        image_control<&ImageControls::auto_white_balance>(
            {V4L2_CID_AUTO_WHITE_BALANCE, boolean, "White Balance Temperature, Auto", 0, 1, 1, 1, 0, {}}),
        image_control<&ImageControls::gain_db, 10>({V4L2_CID_GAIN, integer, "Gain", 0, 240, 1, 0, 0, {}}),
        image_control<&ImageControls::white_balance_k>(
            {V4L2_CID_WHITE_BALANCE_TEMPERATURE, integer, "White Balance Temperature", 2800, 10000, 10, 6500, 0, {}}),
        {{V4L2_CID_EXPOSURE_AUTO,
          menu,
          "Exposure, Auto",
          manual_exposure,
          scene_exposure,
          1,
          scene_exposure,
          0,
          {"Manual Mode", "", "Aperture Priority Mode"}},
         [](const world::CameraSpec& spec) { return spec.controls.auto_exposure ? scene_exposure : manual_exposure; },
         [](std::int32_t value, world::CameraPatch& patch) {
             patch.change([value](world::CameraSpec& spec) { spec.controls.auto_exposure = value != manual_exposure; });
         }},
        {{V4L2_CID_EXPOSURE_ABSOLUTE, integer, "Exposure (Absolute)", 2, 6400, 1, whole(usual_exposure), 0, {}},
         [](const world::CameraSpec& spec) {
             return std::clamp(whole(usual_exposure * std::exp2(spec.controls.exposure_ev)), 2, 6400);
         },
         [](std::int32_t value, world::CameraPatch& patch) {
             patch.change(
                 [value](world::CameraSpec& spec) { spec.controls.exposure_ev = std::log2(value / usual_exposure); });
         }},
        {{V4L2_CID_PAN_ABSOLUTE, integer, "Pan (Absolute)", -648000, 648000, 1, 0, 0, {}},
         [](const world::CameraSpec& spec) {
             return whole(-camera::angles_of(spec.pose.orientation).pan * arcsec_per_rad);
         },
         [](std::int32_t value, world::CameraPatch& patch) { patch.pan_rad = -value / arcsec_per_rad; }},
        {{V4L2_CID_TILT_ABSOLUTE, integer, "Tilt (Absolute)", -324000, 324000, 1, 0, 0, {}},
         [](const world::CameraSpec& spec) {
             return whole(camera::angles_of(spec.pose.orientation).tilt * arcsec_per_rad);
         },
         [](std::int32_t value, world::CameraPatch& patch) { patch.tilt_rad = value / arcsec_per_rad; }},
        {{V4L2_CID_ZOOM_ABSOLUTE, integer, "Zoom, Absolute", 100, 1000, 1, 100, 0, {}},
         [](const world::CameraSpec& spec) { return whole(spec.zoom * 100); },
         [](std::int32_t value, world::CameraPatch& patch) { patch.zoom = value / 100.0; }},
    };
    return all;
}

const CameraControl* find_control(std::uint32_t id) {
    const auto& all = camera_controls();
    const auto found = std::ranges::find(all, id, [](const CameraControl& one) { return one.control.id; });
    return found == all.end() ? nullptr : &*found;
}

}  // namespace

void CameraControls::on_change(Changed changed) {
    std::lock_guard lock(mutex_);
    changed_ = std::move(changed);
}

std::vector<device::DeviceControl> CameraControls::list(std::string_view) {
    std::vector<device::DeviceControl> controls;
    for (const CameraControl& one : camera_controls()) controls.push_back(one.control);
    return controls;
}

Result<std::int32_t> CameraControls::get(std::string_view camera, std::uint32_t id) {
    const CameraControl* const control = find_control(id);
    if (!control) return error(ErrorKind::not_found, "no such control");
    std::lock_guard lock(mutex_);
    const auto found = known_.find(camera);
    if (found == known_.end()) return error(ErrorKind::unavailable, "the camera's state has not been told yet");
    return control->read(found->second);
}

void CameraControls::set(std::string_view camera, std::span<const device::DeviceControlValue> values,
                         std::function<void(Result<void>)> done) {
    engine::SetCamera command{.name = std::string(camera), .patch = {}};
    for (const auto& [id, value] : values) {
        const CameraControl* const control = find_control(id);
        if (!control) return done(error(ErrorKind::not_found, "no such control"));
        control->write(value, command.patch);
    }
    commands_.post(engine::Request<engine::SetCamera>{
        std::move(command),
        [self = weak_from_this(), done = std::move(done)](const Result<engine::CameraReply>& report) {
            if (!report) return done(std::unexpected(report.error()));
            if (const auto alive = self.lock()) alive->told(*report->camera.spec(), true);
            done({});
        }});
}

void CameraControls::refresh(const std::string& camera) {
    commands_.post(engine::Request<engine::GetCamera>{
        {camera}, [self = weak_from_this()](const Result<engine::CameraReply>& report) {
            const auto alive = self.lock();
            if (alive && report) alive->told(*report->camera.spec(), false);
        }});
}

void CameraControls::forget(const std::string& camera) {
    std::lock_guard lock(mutex_);
    known_.erase(camera);
}

void CameraControls::told(const world::CameraSpec& spec, bool by_us) {
    std::lock_guard lock(mutex_);
    const auto before = known_.find(spec.name);
    std::vector<std::uint32_t> ids;
    if (before != known_.end() && !by_us)
        for (const CameraControl& one : camera_controls())
            if (one.read(before->second) != one.read(spec)) ids.push_back(one.control.id);
    known_.insert_or_assign(spec.name, spec);
    if (!ids.empty() && changed_) changed_(spec.name, ids);
}

}  // namespace camrig::cli
