#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "core/camera/ptz_head.h"

/// The spaces of ONVIF PTZ (ver20) and what they mean for a head. Their x is positive to the right where camrig's pan
/// is positive to the left; y and tilt agree. Generic spaces go from -1 to 1 (zoom: 0 to 1) over what the head can;
/// zoom is in equal factors, as heads zoom.
namespace camrig::onvif {

#define CAMRIG_PAN_TILT "http://www.onvif.org/ver10/tptz/PanTiltSpaces/"
#define CAMRIG_ZOOM "http://www.onvif.org/ver10/tptz/ZoomSpaces/"
inline constexpr std::string_view position_space = CAMRIG_PAN_TILT "PositionGenericSpace";
inline constexpr std::string_view translation_space = CAMRIG_PAN_TILT "TranslationGenericSpace";
inline constexpr std::string_view fov_space = CAMRIG_PAN_TILT "TranslationSpaceFov";
inline constexpr std::string_view velocity_space = CAMRIG_PAN_TILT "VelocityGenericSpace";
inline constexpr std::string_view speed_space = CAMRIG_PAN_TILT "GenericSpeedSpace";
inline constexpr std::string_view zoom_position_space = CAMRIG_ZOOM "PositionGenericSpace";
inline constexpr std::string_view zoom_translation_space = CAMRIG_ZOOM "TranslationGenericSpace";
inline constexpr std::string_view zoom_velocity_space = CAMRIG_ZOOM "VelocityGenericSpace";
inline constexpr std::string_view zoom_speed_space = CAMRIG_ZOOM "ZoomGenericSpeedSpace";
#undef CAMRIG_PAN_TILT
#undef CAMRIG_ZOOM

/// A generic axis, which goes from -1 to 1.
struct Axis {
    double middle = 0.0, half = 180.0;
    double degrees(double generic) const { return middle + generic * half; }
    /// What middle and half do not give to the last bit at the ends is not beyond the limits.
    double degrees(double generic, const std::optional<camera::PtzLimits>& limits) const {
        const bool is_inside = limits && std::abs(generic) <= 1.0;
        return is_inside ? std::clamp(degrees(generic), limits->low, limits->high) : degrees(generic);
    }
    double generic(double degrees) const { return half > 0.0 ? std::clamp((degrees - middle) / half, -1.0, 1.0) : 0.0; }
};

inline Axis axis_of(const std::optional<camera::PtzLimits>& limits) {
    if (!limits) return {};
    return {(limits->low + limits->high) / 2, (limits->high - limits->low) / 2};
}

inline Axis pan_axis(const camera::PtzSpec& spec) {
    Axis axis = axis_of(spec.pan_limits_deg);
    axis.half = -axis.half;
    return axis;
}

inline double pan_generic(const camera::PtzSpec& spec, double pan_deg) {
    const Axis axis = axis_of(spec.pan_limits_deg);
    return -axis.generic(pan_deg);
}

inline double zoom_factor(const camera::PtzSpec& spec, double generic) {
    return std::pow(spec.zoom_max, generic);
}

inline double zoom_generic(const camera::PtzSpec& spec, double zoom) {
    return spec.zoom_max > 1.0 ? std::clamp(std::log(zoom) / std::log(spec.zoom_max), 0.0, 1.0) : 0.0;
}

}  // namespace camrig::onvif
