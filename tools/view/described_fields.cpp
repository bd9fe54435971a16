#include "tools/view/described_fields.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <imgui.h>

#include "tools/view/typed_value.h"

namespace camrig::view {
namespace {

using nlohmann::json;

constexpr std::size_t max_text = 1024;
constexpr double widest_slider = 1000;

std::string label_of(const json& field) {
    std::string text = field.value("label", field.at("name").get<std::string>());
    std::ranges::replace(text, '_', ' ');
    return field.contains("unit") ? text + " " + field.at("unit").get<std::string>() : text;
}

/// The new value, or discarded when nobody has changed it.
json changed_number(const json& field, const char* label, double value) {
    const double before = value;
    const bool has_ends = field.contains("minimum") && field.contains("maximum");
    const double low = has_ends ? field.at("minimum").get<double>() : 0,
                 high = has_ends ? field.at("maximum").get<double>() : 0;
    // From micro to milli nobody slides to what he means.
    if (has_ends && (low <= 0 || high / low <= widest_slider)) {
        ImGui::SliderScalar(label, ImGuiDataType_Double, &value, &low, &high, "%.4g");
    } else {
        ImGui::InputDouble(label, &value, 0, 0, "%.6g", ImGuiInputTextFlags_EnterReturnsTrue);
    }
    if (value == before) return json(json::value_t::discarded);
    return field.at("type") == "integer" ? json(static_cast<std::int64_t>(value)) : json(value);
}

json changed_choice(const json& field, const char* label, const json& value) {
    std::vector<std::string> words;
    if (field.contains("null")) words.push_back(field.at("null"));
    for (const json& choice : field.at("choices")) words.push_back(choice);
    const std::string shown = value.is_null() ? words.front() : value.get<std::string>();
    json changed(json::value_t::discarded);
    if (!ImGui::BeginCombo(label, shown.c_str())) return changed;
    for (const std::string& word : words) {
        if (!ImGui::Selectable(word.c_str(), word == shown) || word == shown) continue;
        changed = field.contains("null") && word == words.front() ? json(nullptr) : json(word);
    }
    ImGui::EndCombo();
    return changed;
}

/// What a person has typed, when it is done.
std::optional<std::string> changed_text(const char* label, const std::string& value, const char* hint = "") {
    std::array<char, max_text> text{};
    value.copy(text.data(), text.size() - 1);
    if (!ImGui::InputTextWithHint(label, hint, text.data(), text.size(), ImGuiInputTextFlags_EnterReturnsTrue))
        return std::nullopt;
    return text.data();
}

json changed_flag(const char* label, bool value) {
    return ImGui::Checkbox(label, &value) ? json(value) : json(json::value_t::discarded);
}

/// The parts of an object, in a branch that can be opened. One that is whole is wished for with all its parts.
void draw_object(const json& field, const std::string& label, const json& value,
                 const std::function<void(const json&)>& wish) {
    const std::string name = field.at("name");
    const bool is_whole = field.value("whole", false), is_there = value.is_object();
    if (!ImGui::TreeNode(label.c_str())) return;
    // What must be told something to be there comes with the first part that is typed.
    if (field.contains("null") && (is_there || !is_whole)) {
        const json on = changed_flag("on", is_there);
        if (!on.is_discarded()) wish({{name, on.get<bool>() ? json::object() : json(nullptr)}});
    }
    if (is_there || is_whole) {
        json shown = is_there ? value : json::object();
        for (const json& part : field.at("fields"))
            if (const std::string key = part.at("name"); !is_there) shown[key] = empty_value(part);
        draw_described(field.at("fields"), shown, [&](const json& inner) {
            json changed = is_whole && is_there ? value : json::object();
            changed.update(inner);
            wish({{name, changed}});
        });
    }
    ImGui::TreePop();
}

}  // namespace

void draw_described(const json& fields, const json& values, const std::function<void(const json&)>& wish) {
    for (const json& field : fields) {
        const std::string name = field.at("name"), label = label_of(field);
        const auto found = values.find(name);
        if (found == values.end()) continue;
        const std::string type = field.at("type").get<std::string>();
        const bool can_be_null = field.contains("null");
        json changed(json::value_t::discarded);
        if (field.value("by", "") == "rig") {
            ImGui::LabelText(label.c_str(), "%s", text_of(*found).c_str());
        } else if (field.contains("choices")) {
            changed = changed_choice(field, label.c_str(), *found);
        } else if (type.starts_with("boolean")) {
            changed = changed_flag(label.c_str(), found->is_boolean() && found->get<bool>());
        } else if ((type == "number" || type == "integer") && found->is_number()) {
            changed = changed_number(field, label.c_str(), found->get<double>());
        } else if (type.starts_with("string") || type.starts_with("number") || type.starts_with("integer") ||
                   type.starts_with("array of numbers")) {
            const std::string hint = can_be_null ? field.at("null").get<std::string>() : field.value("word", "");
            if (const auto text = changed_text(label.c_str(), text_of(*found), hint.c_str()))
                changed = typed_value(field, *text);
        } else if (type.starts_with("object") && field.contains("fields")) {
            draw_object(field, label, *found, wish);
        } else {
            ImGui::LabelText(label.c_str(), "%s", text_of(*found).c_str());
        }
        if (!changed.is_discarded()) wish({{name, changed}});
    }
}

}  // namespace camrig::view
