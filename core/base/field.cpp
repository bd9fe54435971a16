#include <algorithm>

#include "core/base/field_of.h"
#include "core/base/number_text.h"

namespace camrig {
namespace {

using nlohmann::json;

/// "1e6", not "1e+06".
std::string short_text(double number) {
    const std::string text = number_text(number);
    const auto e = text.find('e');
    return e == std::string::npos ? text : text.substr(0, e + 1) + std::to_string(std::stoi(text.substr(e + 1)));
}

/// Characters of UTF-8.
double length_of(const std::string& text) {
    return static_cast<double>(std::ranges::count_if(text, [](char c) { return (c & 0xc0) != 0x80; }));
}

std::string joined(const std::vector<std::string>& words, std::string_view between) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : std::string(between)) + word;
    return text;
}

/// "`a`, `b` or `c`"
std::string list_of(const std::vector<std::string>& choices) {
    std::string text;
    for (std::size_t i = 0; i < choices.size(); ++i)
        text += (i == 0 ? "`" : i + 1 < choices.size() ? ", `" : " or `") + choices[i] + "`";
    return text;
}

std::optional<std::string> problem_of_text(const Field& field, const std::string& text) {
    if (!field.word.empty() && text == field.word) return std::nullopt;
    if (!field.choices.empty()) {
        if (std::ranges::find(field.choices, text) != field.choices.end()) return std::nullopt;
        return ": '" + text.substr(0, 40) + "' is none of " + joined(field.choices, ", ");
    }
    // It is shown in terminals.
    const auto is_control = [](char c) { return (c >= 0 && c < 0x20) || c == 0x7f; };
    if (std::ranges::any_of(text, is_control)) return ": must have no control characters";
    if (!field.range.contains(length_of(text))) return ": must have " + field.range.words() + " characters";
    return std::nullopt;
}

}  // namespace

bool Range::contains(double number) const {
    return (is_low_out ? number > low : number >= low) && (is_high_out ? number < high : number <= high);
}

std::string Range::words() const {
    const bool is_plain = has_low() && has_high() && !is_low_out && !is_high_out;
    if (is_plain) return short_text(low) + " to " + short_text(high);
    std::string text;
    if (has_low()) text = (is_low_out ? "over " : "at least ") + short_text(low);
    if (has_high())
        text += (text.empty() ? "" : " and ") + std::string(is_high_out ? "below " : "at most ") + short_text(high);
    return text;
}

std::string Field::plain_type() const {
    std::string text = type.substr(0, type.find(" or null"));
    return word.empty() ? text : text.substr(0, text.find(" or \"" + word));
}

std::string Field::label_text() const {
    if (!label.empty()) return label;
    std::string text = name;
    std::ranges::replace(text, '_', ' ');
    return text;
}

std::string Field::option_text() const {
    if (!option.empty()) return option;
    std::string text = name;
    std::ranges::replace(text, '_', '-');
    return text;
}

std::string Field::doc_text() const {
    std::string text = choices.empty() ? range.words() : list_of(choices);
    if (!text.empty() && type.starts_with("string") && choices.empty()) text = "of " + text + " characters";
    if (!doc.empty()) text += (text.empty() ? "" : ": ") + doc;
    if (is_nullable()) text += (text.empty() ? "" : "; ") + std::string("null: ") + null;
    return text;
}

std::optional<std::string> problem_of(const Field& field, const json& value) {
    if (value.is_number() && !field.range.contains(value.get<double>()))
        return ": must be " + field.range.words() + (field.unit.empty() ? "" : " " + field.unit);
    if (value.is_string()) return problem_of_text(field, value.get_ref<const std::string&>());
    if (!value.is_object()) return std::nullopt;
    for (const Field& part : field.parts) {
        const auto found = value.find(part.name);
        if (found == value.end()) continue;
        if (auto problem = problem_of(part, *found)) return "." + part.name + *problem;
    }
    return std::nullopt;
}

std::string fallback_text(const Field& field, const json& value) {
    if (value.is_null()) return field.is_nullable() ? "null" : "";
    if (value.is_object()) return "";
    if (value.is_number_float()) return short_text(value.get<double>());
    return value.is_string() && value != "" ? value.get<std::string>() : value.dump();
}

json to_json(const Field& field) {
    json out{{"name", field.name}, {"type", field.type}, {"doc", field.doc}};
    if (field.required) out["required"] = true;
    const auto put = [&](const char* key, const std::string& text) {
        if (!text.empty()) out[key] = text;
    };
    put("unit", field.unit);
    put("default", field.fallback);
    put("null", field.null);
    put("word", field.word);
    put("label", field.label);
    const Range& range = field.range;
    if (range.has_low()) out[range.is_low_out ? "exclusive_minimum" : "minimum"] = range.low;
    if (range.has_high()) out[range.is_high_out ? "exclusive_maximum" : "maximum"] = range.high;
    if (!field.choices.empty()) out["choices"] = field.choices;
    if (field.by != Field::By::both) out["by"] = field.by == Field::By::client ? "client" : "rig";
    if (field.is_whole) out["whole"] = true;
    if (!field.parts.empty()) out["fields"] = to_json(field.parts);
    return out;
}

json to_json(const std::vector<Field>& fields) {
    json out = json::array();
    for (const Field& field : fields) out.push_back(to_json(field));
    return out;
}

}  // namespace camrig
