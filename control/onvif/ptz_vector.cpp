#include "control/onvif/ptz_vector.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "control/onvif/ptz_space.h"

namespace camrig::onvif {
namespace {

constexpr double max_fov = 10.0;   ///< halves of the picture that a move may go beyond its middle
constexpr double slowest = 0.001;  ///< share of the head's speed

std::optional<double> number_of(std::optional<std::string_view> text) {
    if (!text) return std::nullopt;
    if (text->starts_with('+')) text->remove_prefix(1);
    double value = 0.0;
    const auto [end, failed] = std::from_chars(text->data(), text->data() + text->size(), value);
    if (failed != std::errc{} || end != text->data() + text->size() || !std::isfinite(value)) return std::nullopt;
    return value;
}

bool is_within(double value, double low, double high) {
    constexpr double rounding = 1e-5;  // of clients that reckon with floats
    return value >= low - rounding && value <= high + rounding;
}

}  // namespace

Answered<Vector> read_vector(XmlElement given, const VectorRule& rule) {
    Vector vector;
    const auto refuse = [&](std::string why) { return invalid_argument(rule.detail, std::move(why)); };
    if (const XmlElement turn = given.child("PanTilt")) {
        vector.space = turn.attribute("space").value_or("");
        if (vector.space == rule.space) vector.space = {};
        const bool is_fov = rule.takes_fov && vector.space == fov_space;
        if (!vector.space.empty() && !is_fov)
            return invalid_argument("SpaceNotSupported", "this space is not supported");
        vector.x = number_of(turn.attribute("x"));
        vector.y = number_of(turn.attribute("y"));
        if (!vector.x || !vector.y) return refuse("PanTilt needs x and y, which are numbers");
        const double end = is_fov ? max_fov : 1.0;
        if (!is_within(*vector.x, -end, end) || !is_within(*vector.y, -end, end))
            return refuse("x and y of PanTilt are out of the range of their space");
        vector.x = std::clamp(*vector.x, -end, end);
        vector.y = std::clamp(*vector.y, -end, end);
    }
    if (const XmlElement zoom = given.child("Zoom")) {
        const auto space = zoom.attribute("space").value_or("");
        if (!space.empty() && space != rule.zoom_space)
            return invalid_argument("SpaceNotSupported", "this space is not supported");
        vector.zoom = number_of(zoom.attribute("x"));
        if (!vector.zoom || !is_within(*vector.zoom, rule.zoom_low, 1.0))
            return refuse("Zoom needs x, which is a number in the range of its space");
        vector.zoom = std::clamp(*vector.zoom, rule.zoom_low, 1.0);
    }
    if (!vector.x && !vector.zoom) return refuse("neither PanTilt nor Zoom is named");
    return vector;
}

double speed_of(XmlElement given, bool turns) {
    const XmlElement turn = turns ? given.child("PanTilt") : XmlElement();
    double speed =
        std::hypot(number_of(turn.attribute("x")).value_or(0.0), number_of(turn.attribute("y")).value_or(0.0));
    if (!turn) speed = std::abs(number_of(given.child("Zoom").attribute("x")).value_or(0.0));
    return speed > 0.0 ? std::clamp(speed, slowest, 1.0) : 1.0;
}

}  // namespace camrig::onvif
