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
    const std::size_t middle = text.find('T');
    std::string_view days = text.substr(1, middle - 1);
    std::string_view time = middle == std::string_view::npos ? "" : text.substr(middle + 1);
    if (middle != std::string_view::npos && time.empty()) return std::nullopt;
    double seconds = 0.0;
    bool has_any = false;
    const auto take = [&](std::string_view& from, char unit, double factor) {
        const std::size_t at = from.find(unit);
        if (at == std::string_view::npos) return true;
        double value = 0.0;
        const auto [end, failed] = std::from_chars(from.data(), from.data() + at, value, std::chars_format::fixed);
        if (failed != std::errc{} || end != from.data() + at || !(value >= 0.0)) return false;
        seconds += value * factor;
        has_any = true;
        from.remove_prefix(at + 1);
        return true;
    };
    constexpr double day_s = 86'400.0;
    if (!take(days, 'Y', 365.0 * day_s) || !take(days, 'M', 30.0 * day_s) || !take(days, 'D', day_s))
        return std::nullopt;
    if (!take(time, 'H', 3600.0) || !take(time, 'M', 60.0) || !take(time, 'S', 1.0)) return std::nullopt;
    if (!has_any || !days.empty() || !time.empty() || !(seconds * 1e9 <= static_cast<double>(longest_ns)))
        return std::nullopt;
    return static_cast<TimeNs>(std::llround(seconds * 1e9));
}

}  // namespace camrig::onvif
