#include "tools/view/typed_value.h"

#include <cmath>
#include <cstdint>
#include <sstream>

namespace camrig::view {

using nlohmann::json;

std::string text_of(const json& value) {
    if (value.is_null()) return "";
    if (value.is_string()) return value.get<std::string>();
    if (!value.is_array()) return value.dump();
    std::string text;
    for (const json& each : value) text += (text.empty() ? "" : " ") + text_of(each);
    return text;
}

json typed_value(const json& field, const std::string& text) {
    const bool is_empty = text.find_first_not_of(' ') == std::string::npos;
    if (is_empty && field.contains("null")) return nullptr;
    const std::string type = field.at("type");
    if (type.starts_with("string")) return text;
    // What is no number goes to the rig as it is: its answer says what would be right.
    const auto number_of = [](const std::string& word) {
        const json number = json::parse(word, nullptr, false);
        return number.is_number() ? number : json(word);
    };
    if (!type.starts_with("array")) return number_of(text);
    json list = json::array();
    std::istringstream words(text);
    for (std::string word; words >> word;) list.push_back(number_of(word));
    return list;
}

json empty_value(const json& field) {
    if (field.contains("default")) return typed_value(field, field.at("default"));
    if (field.contains("choices")) return field.at("choices").at(0);
    if (field.contains("null")) return nullptr;
    const std::string type = field.at("type");
    if (type == "integer") return static_cast<std::int64_t>(std::ceil(field.value("minimum", 0.0)));
    if (type == "number") return field.value("minimum", 0.0);
    return type.starts_with("array") ? json::array() : type.starts_with("boolean") ? json(false) : json("");
}

}  // namespace camrig::view
