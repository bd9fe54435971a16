#include <algorithm>
#include <cstdio>
#include <numbers>

#include "tools/view/frustum.h"
#include "tools/view/panels.h"

namespace camrig::view {
namespace {

constexpr float picture_width = 228;

void draw_entry(Session& session, const client::CameraState& camera) {
    ImGui::PushID(camera.name.c_str());
    const std::string label = camera.name + (camera.mount ? "  (on " + camera.mount->actor + ")" : "");
    if (ImGui::Selectable(label.c_str(), camera.name == session.selected, ImGuiSelectableFlags_AllowDoubleClick)) {
        session.selected = camera.name;
        // Twice: look through it.
        if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left))
            session.fly = FlyCamera::at(session.pose_of_camera(camera));
    }
    if (const ImTextureID picture = session.textures.find(camera.name)) {
        const glm::dvec2 size = session.textures.size(camera.name);
        const auto height = static_cast<float>(picture_width * size.y / std::max(1.0, size.x));
        ImGui::Image(picture, {picture_width, std::min(height, picture_width)});
        if (ImGui::IsItemClicked()) session.selected = camera.name;
    }
    ImGui::PopID();
}

}  // namespace

void begin_panel(const char* title, const Area& area) {
    ImGui::SetNextWindowPos(area.origin);
    ImGui::SetNextWindowSize(area.extent);
    ImGui::Begin(title, nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoBringToFrontOnFocus |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav);
}

void draw_camera_list(Session& session, const Area& area) {
    begin_panel("cameras", area);
    const ImVec2 size(76, 0);
    if (ImGui::Button("New (N)", size)) session.create_camera();
    ImGui::SameLine();
    if (ImGui::Button("Duplicate", size)) session.duplicate_selected();
    ImGui::SameLine();
    if (ImGui::Button("Delete", size)) session.delete_selected();
    if (ImGui::Button("Save the arrangement (Ctrl+S)", {-1, 0})) session.save();
    if (!session.notice.empty()) ImGui::TextWrapped("%s", session.notice.c_str());
    ImGui::Separator();
    ImGui::BeginChild("all");
    for (const auto& camera : session.model.cameras) draw_entry(session, camera);
    ImGui::EndChild();
    ImGui::End();
}

}  // namespace camrig::view
