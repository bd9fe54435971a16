#pragma once

#include <optional>
#include <string_view>

#include "control/onvif/soap.h"

/// Positions, translations, velocities and speeds of PTZ requests. Pure.
namespace camrig::onvif {

/// The PanTilt and the Zoom of a vector of a request; what it does not name is empty.
struct Vector {
    std::optional<double> x, y, zoom;
    std::string_view space;  ///< of pan and tilt; empty: the default
};

/// What a request's vector may be; `detail` is what a fault says of one that is not.
struct VectorRule {
    std::string_view detail;
    std::string_view space, zoom_space;
    double zoom_low = -1.0;
    bool takes_fov = false;
};
/// Each part of it within its space; SpaceNotSupported, else the rule's detail.
Answered<Vector> read_vector(XmlElement given, const VectorRule& rule);

/// Share of the head's speed: the length of the vector of pan and tilt, else, and of what does not turn, that of zoom.
/// Many clients send zeros where their users chose none.
double speed_of(XmlElement given, bool turns = true);

}  // namespace camrig::onvif
