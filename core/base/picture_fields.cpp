#include "core/base/picture_fields.h"

namespace camrig {

using nlohmann::json;

std::optional<ImageSize> read_size(JsonReader& reader, std::string_view key) {
    const json* value = reader.find(key);
    if (!value) return std::nullopt;
    const bool good =
        value->is_array() && value->size() == 2 && (*value)[0].is_number_integer() && (*value)[1].is_number_integer();
    if (!good) {
        reader.fail(key, "expected [width, height] in pixels");
        return std::nullopt;
    }
    // A fence against numbers that do not fit an int.
    const auto side = [](const json& given) {
        return given.get<double>() >= 0 && given.get<double>() <= 1e6 ? given.get<int>() : 1'000'000;
    };
    return ImageSize{side((*value)[0]), side((*value)[1])};
}

std::optional<Rate> read_rate(JsonReader& reader, std::string_view key) {
    const json* value = reader.find(key);
    if (!value) return std::nullopt;
    if (!value->is_string() && !value->is_number()) {
        reader.fail(key, "expected a number or \"num/den\"");
        return std::nullopt;
    }
    auto rate = value->is_string() ? Rate::parse(value->get_ref<const std::string&>())
                                   : Rate::from_number(value->get<double>());
    if (!rate) {
        reader.fail(key, rate.error().message);
        return std::nullopt;
    }
    return *rate;
}

json size_to_json(ImageSize size) {
    return {size.width, size.height};
}

json rate_to_json(const Rate& rate) {
    return rate.den() == 1 ? json(rate.num()) : json(rate.to_string());
}

}  // namespace camrig
