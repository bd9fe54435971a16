#include "tools/view/panels.h"

namespace camrig::view {
namespace {

constexpr const char* title = "question";
const ImVec2 button_size(110, 0);

}  // namespace

void draw_question(Session& session, const Area& area) {
    // A popup stays open until it is told, also after a key has answered.
    if (!session.question && !ImGui::IsPopupOpen(title)) return;
    if (session.question && !ImGui::IsPopupOpen(title)) ImGui::OpenPopup(title);
    ImGui::SetNextWindowPos({area.origin.x + area.extent.x / 2, area.origin.y + area.extent.y / 2}, ImGuiCond_Always,
                            {0.5F, 0.5F});
    if (!ImGui::BeginPopupModal(title, nullptr,
                                ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoNav |
                                    ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings))
        return;
    if (session.question) {
        ImGui::TextUnformatted(session.question->words.c_str());
        const std::string yes = session.question->yes + " (Enter)";
        if (ImGui::Button(yes.c_str(), button_size)) session.answer(true);
        ImGui::SameLine();
        if (ImGui::Button("Cancel (Esc)", button_size)) session.answer(false);
    }
    if (!session.question) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
}

}  // namespace camrig::view
