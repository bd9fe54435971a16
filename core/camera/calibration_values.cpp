#include "core/camera/calibration_values.h"

#include <charconv>
#include <cmath>
#include <string_view>

#include "core/camera/lens_map.h"

namespace camrig::camera {

std::unexpected<Error> bad_value(const std::string& key, const std::string& what) {
    return error(ErrorKind::invalid_argument, key + ": " + what);
}

Result<double> number_value(const nlohmann::json& value, const std::string& key) {
    if (!value.is_string()) return bad_value(key, "must be a number");
    std::string_view text = value.get_ref<const std::string&>();
    if (text.starts_with('+')) text.remove_prefix(1);
    double out = 0.0;
    const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), out);
    if (status != std::errc() || end != text.data() + text.size() || !std::isfinite(out))
        return bad_value(key, "must be a finite number");
    return out;
}

Result<int> whole_number_value(const nlohmann::json& value, const std::string& key, int low, int high) {
    const auto out = number_value(value, key);
    if (!out) return std::unexpected(out.error());
    if (*out != std::floor(*out) || *out < low || *out > high)
        return bad_value(key, "must be a whole number from " + std::to_string(low) + " to " + std::to_string(high));
    return static_cast<int>(*out);
}

Result<std::vector<double>> number_list(const nlohmann::json& value, const std::string& key, std::size_t low,
                                        std::size_t high) {
    if (!value.is_array()) return bad_value(key, "must be a list of numbers");
    if (value.size() < low || value.size() > high) {
        return bad_value(key, "must hold " + (low == high ? "" : std::to_string(low) + " to ") + std::to_string(high) +
                                  " numbers, not " + std::to_string(value.size()));
    }
    std::vector<double> out;
    for (const nlohmann::json& item : value) {
        const auto one = number_value(item, key + "[" + std::to_string(out.size()) + "]");
        if (!one) return std::unexpected(one.error());
        out.push_back(*one);
    }
    return out;
}

Result<Lens> lens_from_opencv(std::vector<double> k, const std::string& key) {
    for (std::size_t i = 8; i < k.size(); ++i) {
        if (k[i] != 0.0)
            return error(ErrorKind::unsupported, key +
                                                     ": thin prism and tilt terms (beyond the eighth number) are not "
                                                     "modelled; calibrate without them");
    }
    switch (k.size()) {
        case 0:
            return Lens{};
        case 4:
            k.push_back(0.0);
            [[fallthrough]];
        case 5:
            return make_lens(LensModel::plumb_bob, k);
        case 8:
        case 12:
        case 14:
            k.resize(8);
            return make_lens(LensModel::rational_polynomial, k);
        default:
            return bad_value(key,
                             "has " + std::to_string(k.size()) + " numbers; OpenCV's lists have 4, 5, 8, 12 or 14");
    }
}

}  // namespace camrig::camera
