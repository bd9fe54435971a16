#include "control/onvif/operation.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace camrig::onvif {

bool Asked::has_heads() const {
    return std::ranges::any_of(cameras, [](const CameraSpecRef& spec) { return spec->ptz.has_value(); });
}

Answered<CameraSpecRef> camera_of(const Asked& asked, std::string_view child, std::string_view detail) {
    const std::string_view token = asked.request.text(child);
    const std::string_view name = child == "ProfileToken" ? camera_of_token(token) : token;
    for (const CameraSpecRef& spec : asked.cameras)
        if (spec->name == name) return spec;
    return invalid_argument(detail, "there is no such " + std::string(child));
}

Role least_role(Access access) {
    switch (access) {
        case Access::pre_auth:
        case Access::read_system:
        case Access::read_media:
            return Role::user;
        case Access::read_system_sensitive:
        case Access::actuate:
            return Role::op;
        case Access::read_system_secret:
        case Access::write_system:
        case Access::unrecoverable:
            return Role::administrator;
    }
    return Role::administrator;
}

bool is_change(Access access) {
    return access == Access::actuate || access == Access::write_system || access == Access::unrecoverable;
}

std::string response(std::string_view operation, std::string_view content) {
    return element(std::string(operation) + "Response", content);
}

std::optional<TimeNs> duration_of(std::string_view text, TimeNs longest_ns) {
    if (!text.starts_with('P')) return std::nullopt;
    text.remove_prefix(1);
    double seconds = 0.0;
    bool has_any = false;
    // "nD", of what comes before 'T', and then hours, minutes and seconds.
    const auto take = [&](char unit, double factor) {
        const std::size_t at = text.find(unit);
        if (at == std::string_view::npos) return true;
        double value = 0.0;
        const auto [end, failed] = std::from_chars(text.data(), text.data() + at, value, std::chars_format::fixed);
        if (failed != std::errc{} || end != text.data() + at || !(value >= 0.0)) return false;
        seconds += value * factor;
        has_any = true;
        text.remove_prefix(at + 1);
        return true;
    };
    if (!text.starts_with('T') && !take('D', 86'400.0)) return std::nullopt;
    if (text.starts_with('T')) {
        text.remove_prefix(1);
        if (text.empty() || !take('H', 3600.0) || !take('M', 60.0) || !take('S', 1.0)) return std::nullopt;
    }
    if (!has_any || !text.empty() || !(seconds * 1e9 <= static_cast<double>(longest_ns))) return std::nullopt;
    return static_cast<TimeNs>(std::llround(seconds * 1e9));
}

}  // namespace camrig::onvif
