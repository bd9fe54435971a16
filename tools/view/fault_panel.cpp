#include <algorithm>
#include <map>
#include <string>

#include "tools/view/described_fields.h"
#include "tools/view/panels.h"
#include "tools/view/typed_value.h"

namespace camrig::view {
namespace {

using nlohmann::json;

/// What is being made ready, by kind; the window's own, for a fault is set as a whole.
struct Draft {
    std::string kind;
    float severity = 1.0f;
    float seconds = 0.0f;  ///< 0: until it is cleared
    std::map<std::string, json> params;
};

std::string title_of(const client::FaultState& fault) {
    char severity[16];
    std::snprintf(severity, sizeof severity, "%.2g", fault.severity);
    return fault.kind + " " + severity;
}

void draw_present(Session& session, const std::string& camera) {
    if (!session.model.faults) return;
    for (const client::FaultState& fault : *session.model.faults) {
        if (fault.camera != camera) continue;
        const std::int64_t id = fault.id;
        ImGui::PushID(static_cast<int>(id));
        if (ImGui::SmallButton("x"))
            session.link.edit("fault/" + std::to_string(id), [id](const client::Rig& rig) { rig.clear_fault(id); });
        ImGui::SameLine();
        ImGui::TextUnformatted(title_of(fault).c_str());
        ImGui::PopID();
    }
}

/// The parameters of a kind, as they are in the draft or, where nobody has touched them, as the rig has them.
void edit_params(const json& kind, json& draft) {
    json shown = draft;
    for (const json& field : kind.at("fields")) {
        const std::string key = field.at("name");
        if (shown.contains(key)) continue;
        shown[key] = empty_value(field);
    }
    draw_described(kind.at("fields"), shown, [&](const json& wish) { draft.update(wish); });
}

}  // namespace

void draw_faults(Session& session, const std::string& camera, const json& kinds) {
    if (!ImGui::TreeNode("faults")) return;
    draw_present(session, camera);
    static Draft draft;
    const auto chosen = std::ranges::find_if(kinds, [&](const json& kind) { return kind.at("name") == draft.kind; });
    if (ImGui::BeginCombo("kind", chosen == kinds.end() ? "choose" : draft.kind.c_str())) {
        for (const json& kind : kinds) {
            const std::string name = kind.at("name");
            if (ImGui::Selectable(name.c_str(), name == draft.kind)) draft.kind = name;
            if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", kind.value("doc", "").c_str());
        }
        ImGui::EndCombo();
    }
    if (chosen != kinds.end()) {
        ImGui::SliderFloat("severity", &draft.severity, 0, 1, "%.2f");
        ImGui::InputFloat("seconds, 0: on", &draft.seconds, 0, 0, "%.1f");
        json& params = draft.params.try_emplace(draft.kind, json::object()).first->second;
        edit_params(*chosen, params);
        if (ImGui::SmallButton("set")) {
            json call{{"camera", camera}, {"kind", draft.kind}, {"severity", draft.severity}, {"params", params}};
            if (draft.seconds > 0)
                call["end_s"] = static_cast<double>(session.model.world.world_ns) * 1e-9 + draft.seconds;
            session.link.order([call = std::move(call)](const client::Rig& rig) { rig.call("fault.set", call); });
        }
        ImGui::SameLine();
    }
    if (ImGui::SmallButton("wipe")) session.link.order([camera](const client::Rig& rig) { rig.wipe(camera); });
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("its wiper: ends dirt, drops and condensation");
    ImGui::TreePop();
}

}  // namespace camrig::view
