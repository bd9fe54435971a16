#include "control/onvif/operation.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace camrig::onvif {

bool Asked::has_heads() const {
    return std::ranges::any_of(cameras, [](const CameraSpecRef& spec) { return spec->ptz.has_value(); });
}

Answered<CameraSpecRef> camera_of(const Asked& asked, std::string_view child, std::string_view detail) {
    const std::string_view name = camera_of_token(asked.request.text(child));
    for (const CameraSpecRef& spec : asked.cameras)
        if (spec->name == name) return spec;
    return invalid_argument(detail, "there is no such " + std::string(child));
}

std::string response(std::string_view operation, std::string_view content) {
    return element(std::string(operation) + "Response", content);
}

std::optional<TimeNs> duration_of(std::string_view text) {
    constexpr double longest_s = 86'400;
    if (!text.starts_with("PT") || text.size() < 3) return std::nullopt;
    text.remove_prefix(2);
    double seconds = 0.0;
    for (const auto& [unit, factor] : {std::pair{'H', 3600.0}, {'M', 60.0}, {'S', 1.0}}) {
        const std::size_t at = text.find(unit);
        if (at == std::string_view::npos) continue;
        double value = 0.0;
        const auto [end, failed] = std::from_chars(text.data(), text.data() + at, value, std::chars_format::fixed);
        if (failed != std::errc{} || end != text.data() + at || !(value >= 0.0)) return std::nullopt;
        seconds += value * factor;
        text.remove_prefix(at + 1);
    }
    if (!text.empty() || !(seconds <= longest_s)) return std::nullopt;
    return static_cast<TimeNs>(std::llround(seconds * 1e9));
}

}  // namespace camrig::onvif
