#include "tools/camrig/control_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>
#include <type_traits>

#include <linux/videodev2.h>

namespace camrig::cli {
namespace {

constexpr double arcsec_per_deg = 3600.0, arcsec_per_rad = arcsec_per_deg * 180.0 / std::numbers::pi;
constexpr int manual_exposure = V4L2_EXPOSURE_MANUAL, scene_exposure = V4L2_EXPOSURE_APERTURE_PRIORITY;
/// exposure_absolute (in 0.1 ms) that stands for the scene's own exposure.
constexpr double usual_exposure = 100;

/// Exposure of a sensor in V4L2's unit.
constexpr double exposure_units_per_s = 1e4;
constexpr std::int32_t longest_exposure = 100'000;

std::int32_t whole(double value) {
    return static_cast<std::int32_t>(std::lround(value));
}

/// Changes the sensor of a camera that has one, the image controls of another.
template <class OfSensor, class OfPicture>
void change_either(ControlChange& change, OfSensor of_sensor, OfPicture of_picture) {
    change.camera().change([=](world::CameraSpec& spec) {
        if (spec.sensor)
            of_sensor(*spec.sensor);
        else
            of_picture(spec.controls);
    });
}

/// Where its last command brings it; where that never ends, where it was when the camera was asked.
std::optional<camera::PtzPosition> target_of(const KnownCamera& known) {
    const auto* head = head_of(known);
    if (head == nullptr) return std::nullopt;
    if (head->never_stands()) return known.head ? known.head->position : camera::PtzPosition{};
    return head->status(head->arrives_ns()).position;
}

/// The whole arc seconds within limits in degrees.
std::pair<std::int32_t, std::int32_t> arcsec_range(double low_deg, double high_deg) {
    return {static_cast<std::int32_t>(std::ceil(low_deg * arcsec_per_deg - 1e-6)),
            static_cast<std::int32_t>(std::floor(high_deg * arcsec_per_deg + 1e-6))};
}

/// One that stands for a member of the camera's image controls, in steps of 1 / steps_per_unit.
template <auto member, int steps_per_unit = 1>
CameraControl image_control(device::DeviceControl control) {
    return {std::move(control),
            [](const KnownCamera& known) {
                return whole(static_cast<double>(known.camera.spec()->controls.*member) * steps_per_unit);
            },
            [](std::int32_t value, const KnownCamera&, ControlChange& change) {
                change.camera().change([value](world::CameraSpec& spec) {
                    using Member = std::remove_reference_t<decltype(spec.controls.*member)>;
                    spec.controls.*member = static_cast<Member>(value / double{steps_per_unit});
                });
            }};
}

/// Whole degrees a second.
std::pair<std::int32_t, std::int32_t> speeds_of(const camera::PtzSpec& head) {
    const auto most = static_cast<std::int32_t>(std::ceil(head.speed_deg_s));
    return {-most, most};
}

}  // namespace

const sensor::SensorSpec* sensor_of(const KnownCamera& known) {
    const auto& sensor = known.camera.spec()->sensor;
    return sensor ? &*sensor : nullptr;
}

const camera::PtzHead* head_of(const KnownCamera& known) {
    const auto head = known.camera.head();
    return head ? *head : nullptr;
}

std::int32_t read_control(const CameraControl& control, const KnownCamera& known) {
    const auto target = control.at ? target_of(known) : std::nullopt;
    return target ? control.at(*target) : control.read(known);
}

device::DeviceControl listed_for(const CameraControl& one, const KnownCamera* known) {
    device::DeviceControl control = one.control;
    const camera::PtzHead* const head = known ? head_of(*known) : nullptr;
    if (head && one.range_on) std::tie(control.minimum, control.maximum) = one.range_on(head->spec());
    if (known && sensor_of(*known) && one.range_of_sensors)
        std::tie(control.minimum, control.maximum) = *one.range_of_sensors;
    control.default_value = std::clamp(control.default_value, control.minimum, control.maximum);
    return control;
}

bool has_control(const CameraControl& one, const KnownCamera* known) {
    if (one.is_of_heads) return known && head_of(*known);
    return !one.is_of_sensors || (known && sensor_of(*known));
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
        {{V4L2_CID_AUTO_WHITE_BALANCE, boolean, "White Balance Temperature, Auto", 0, 1, 1, 1, 0, {}},
         [](const KnownCamera& known) {
             const auto* sensor = sensor_of(known);
             return (sensor ? !sensor->white_balance_k : known.camera.spec()->controls.auto_white_balance) ? 1 : 0;
         },
         [](std::int32_t value, const KnownCamera&, ControlChange& change) {
             change_either(
                 change,
                 [value, manual_k = change.manual.white_balance_k](sensor::SensorSpec& sensor) {
                     if (value != 0)
                         sensor.white_balance_k.reset();
                     else if (!sensor.white_balance_k)
                         sensor.white_balance_k = manual_k;
                 },
                 [value](ImageControls& controls) { controls.auto_white_balance = value != 0; });
         }},
        {.control = {V4L2_CID_GAIN, integer, "Gain", 0, 240, 1, 0, 0, {}},
         .read =
             [](const KnownCamera& known) {
                 const auto* sensor = sensor_of(known);
                 return whole(10.0 * (sensor ? sensor->gain_db : known.camera.spec()->controls.gain_db));
             },
         .write =
             [](std::int32_t value, const KnownCamera&, ControlChange& change) {
                 change_either(
                     change, [value](sensor::SensorSpec& sensor) { sensor.gain_db = value / 10.0; },
                     [value](ImageControls& controls) { controls.gain_db = value / 10.0; });
             },
         .range_of_sensors = std::pair(0, 480)},
        {.control =
             {V4L2_CID_WHITE_BALANCE_TEMPERATURE, integer, "White Balance Temperature", 2800, 10000, 10, 6500, 0, {}},
         .read =
             [](const KnownCamera& known) {
                 const auto* sensor = sensor_of(known);
                 return whole(sensor ? sensor->white_balance_k.value_or(known.manual.white_balance_k)
                                     : known.camera.spec()->controls.white_balance_k);
             },
         .write =
             [](std::int32_t value, const KnownCamera&, ControlChange& change) {
                 change.manual.white_balance_k = value;
                 change_either(
                     change,
                     [value](sensor::SensorSpec& sensor) {
                         if (sensor.white_balance_k) sensor.white_balance_k = value;
                     },
                     [value](ImageControls& controls) { controls.white_balance_k = value; });
             },
         .range_of_sensors = std::pair(2000, 12'000)},
        {.control = {V4L2_CID_POWER_LINE_FREQUENCY,
                     menu,
                     "Power Line Frequency",
                     V4L2_CID_POWER_LINE_FREQUENCY_DISABLED,
                     V4L2_CID_POWER_LINE_FREQUENCY_60HZ,
                     1,
                     V4L2_CID_POWER_LINE_FREQUENCY_DISABLED,
                     0,
                     {"Disabled", "50 Hz", "60 Hz"}},
         .read =
             [](const KnownCamera& known) {
                 // Others than these two are said as the nearer one.
                 const double hz = sensor_of(known) ? sensor_of(known)->flicker_hz : 0.0;
                 return std::int32_t{hz == 0.0   ? V4L2_CID_POWER_LINE_FREQUENCY_DISABLED
                                     : hz < 55.0 ? V4L2_CID_POWER_LINE_FREQUENCY_50HZ
                                                 : V4L2_CID_POWER_LINE_FREQUENCY_60HZ};
             },
         .write =
             [](std::int32_t value, const KnownCamera&, ControlChange& change) {
                 constexpr double hz_of[] = {0.0, 50.0, 60.0};
                 change_either(
                     change, [hz = hz_of[value]](sensor::SensorSpec& sensor) { sensor.flicker_hz = hz; },
                     [](ImageControls&) {});
             },
         .is_of_sensors = true},
        {{V4L2_CID_EXPOSURE_AUTO,
          menu,
          "Exposure, Auto",
          manual_exposure,
          scene_exposure,
          1,
          scene_exposure,
          0,
          {"Manual Mode", "", "Aperture Priority Mode"}},
         [](const KnownCamera& known) {
             const auto* sensor = sensor_of(known);
             return (sensor ? !sensor->exposure_s : known.camera.spec()->controls.auto_exposure) ? scene_exposure
                                                                                                 : manual_exposure;
         },
         [](std::int32_t value, const KnownCamera&, ControlChange& change) {
             change_either(
                 change,
                 [value, manual_s = change.manual.exposure_s](sensor::SensorSpec& sensor) {
                     if (value != manual_exposure)
                         sensor.exposure_s.reset();
                     else if (!sensor.exposure_s)
                         sensor.exposure_s = manual_s;
                 },
                 [value](ImageControls& controls) { controls.auto_exposure = value != manual_exposure; });
         }},
        {.control =
             {V4L2_CID_EXPOSURE_ABSOLUTE, integer, "Exposure (Absolute)", 2, 6400, 1, whole(usual_exposure), 0, {}},
         .read =
             [](const KnownCamera& known) {
                 if (const auto* sensor = sensor_of(known))
                     return std::clamp(
                         whole(sensor->exposure_s.value_or(known.manual.exposure_s) * exposure_units_per_s), 1,
                         longest_exposure);
                 return std::clamp(whole(usual_exposure * std::exp2(known.camera.spec()->controls.exposure_ev)), 2,
                                   6400);
             },
         .write =
             [](std::int32_t value, const KnownCamera&, ControlChange& change) {
                 change.manual.exposure_s = value / exposure_units_per_s;
                 change_either(
                     change,
                     [exposure_s = change.manual.exposure_s](sensor::SensorSpec& sensor) {
                         if (sensor.exposure_s) sensor.exposure_s = exposure_s;
                     },
                     [value](ImageControls& controls) { controls.exposure_ev = std::log2(value / usual_exposure); });
             },
         .range_of_sensors = std::pair(1, longest_exposure)},
        // Of old "Exposure, Auto Priority", which says less.
        {.control = {V4L2_CID_EXPOSURE_AUTO_PRIORITY, boolean, "Exposure, Dynamic Framerate", 0, 1, 1, 0, 0, {}},
         .read =
             [](const KnownCamera& known) {
                 const auto* sensor = sensor_of(known);
                 return std::int32_t{sensor && sensor->dynamic_framerate};
             },
         .write =
             [](std::int32_t value, const KnownCamera&, ControlChange& change) {
                 change_either(
                     change, [value](sensor::SensorSpec& sensor) { sensor.dynamic_framerate = value != 0; },
                     [](ImageControls&) {});
             },
         .is_of_sensors = true},
        {{V4L2_CID_PAN_ABSOLUTE, integer, "Pan (Absolute)", -648000, 648000, 1, 0, 0, {}},
         [](const KnownCamera& known) {
             return whole(-camera::angles_of(known.camera.spec()->pose.orientation).pan * arcsec_per_rad);
         },
         [](std::int32_t value, const KnownCamera& known, ControlChange& change) {
             if (head_of(known))
                 change.to().pan_deg = -value / arcsec_per_deg;
             else
                 change.camera().pan_rad = -value / arcsec_per_rad;
         },
         [](const camera::PtzSpec& head) {
             const auto limits = head.pan_limits_deg.value_or(camera::PtzLimits{-180, 180});
             return arcsec_range(-limits.high, -limits.low);
         },
         [](const camera::PtzPosition& position) { return whole(-position.pan_deg * arcsec_per_deg); }},
        {{V4L2_CID_TILT_ABSOLUTE, integer, "Tilt (Absolute)", -324000, 324000, 1, 0, 0, {}},
         [](const KnownCamera& known) {
             return whole(camera::angles_of(known.camera.spec()->pose.orientation).tilt * arcsec_per_rad);
         },
         [](std::int32_t value, const KnownCamera& known, ControlChange& change) {
             if (head_of(known))
                 change.to().tilt_deg = value / arcsec_per_deg;
             else
                 change.camera().tilt_rad = value / arcsec_per_rad;
         },
         [](const camera::PtzSpec& head) { return arcsec_range(head.tilt_limits_deg.low, head.tilt_limits_deg.high); },
         [](const camera::PtzPosition& position) { return whole(position.tilt_deg * arcsec_per_deg); }},
        {{V4L2_CID_ZOOM_ABSOLUTE, integer, "Zoom, Absolute", 100, 1000, 1, 100, 0, {}},
         [](const KnownCamera& known) { return whole(known.camera.spec()->zoom * 100); },
         [](std::int32_t value, const KnownCamera& known, ControlChange& change) {
             if (head_of(known))
                 change.to().zoom = value / 100.0;
             else
                 change.camera().zoom = value / 100.0;
         },
         [](const camera::PtzSpec& head) {
             return std::pair(100, static_cast<std::int32_t>(std::floor(head.zoom_max * 100)));
         },
         [](const camera::PtzPosition& position) { return whole(position.zoom * 100); }},
        // Speeds are set and not read back: a head does not say how fast it goes.
        {{V4L2_CID_PAN_SPEED, integer, "Pan, Speed", 0, 0, 1, 0, 0, {}},
         [](const KnownCamera&) { return 0; },
         [](std::int32_t value, const KnownCamera&, ControlChange& change) { change.at_speed().pan_deg = -value; },
         speeds_of,
         nullptr,
         true},
        {{V4L2_CID_TILT_SPEED, integer, "Tilt, Speed", 0, 0, 1, 0, 0, {}},
         [](const KnownCamera&) { return 0; },
         [](std::int32_t value, const KnownCamera&, ControlChange& change) { change.at_speed().tilt_deg = value; },
         speeds_of,
         nullptr,
         true},
    };
    return all;
}

const CameraControl* find_control(std::uint32_t id) {
    const auto& all = camera_controls();
    const auto found = std::ranges::find(all, id, [](const CameraControl& one) { return one.control.id; });
    return found == all.end() ? nullptr : &*found;
}

}  // namespace camrig::cli
