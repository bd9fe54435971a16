#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <GLFW/glfw3.h>

#include "tools/view/frustum.h"
#include "tools/view/panels.h"

namespace camrig::view {
namespace {

constexpr double frustum_m = 1.2;
constexpr double speed_m_s = 4;
constexpr double fast = 4;
constexpr double wheel_m = 0.6;
constexpr ImU32 plain = IM_COL32(80, 190, 255, 230);
constexpr ImU32 chosen = IM_COL32(255, 190, 40, 255);
constexpr ImU32 mounted = IM_COL32(150, 150, 150, 220);

ImVec2 on_screen(glm::dvec2 point) {
    return {static_cast<float>(point.x), static_cast<float>(point.y)};
}

glm::dvec2 point_of(ImVec2 at) {
    return {at.x, at.y};
}

/// Of what the picture on the screen was taken with, which is older than session.fly.
struct Shown {
    camera::Pose pose;
    double vfov_rad = PictureLink::vfov_deg * std::numbers::pi / 180;
};

void steer(Session& session, const Area& area, bool is_hovered) {
    ImGuiIO& io = ImGui::GetIO();
    const double focal_px = area.extent.y / 2 / std::tan(PictureLink::vfov_deg * std::numbers::pi / 360);
    if (is_hovered && io.MouseWheel != 0) session.fly.go(io.MouseWheel * wheel_m * (io.KeyShift ? fast : 1), 0, 0);
    if (ImGui::IsMouseDragging(ImGuiMouseButton_Right, 0) && ImGui::IsItemActive())
        session.fly.drag(point_of(io.MouseDelta), focal_px);
    if (io.WantTextInput || io.KeyCtrl) return;
    const double step = speed_m_s * (io.KeyShift ? fast : 1) * std::min(io.DeltaTime, 0.1F);
    const auto held = [&](int plus, int minus) {
        // Asked of GLFW: the keys of ImGui::IsKeyDown have other numbers before version 1.87 than after.
        GLFWwindow* const window = ::glfwGetCurrentContext();
        return step * (::glfwGetKey(window, plus) - ::glfwGetKey(window, minus));
    };
    session.fly.go(held(GLFW_KEY_W, GLFW_KEY_S), held(GLFW_KEY_A, GLFW_KEY_D), held(GLFW_KEY_E, GLFW_KEY_Q));
}

/// Its picture where the frustum ends, when all of that is before the eye.
void draw_live_picture(const Session& session, const Sight& sight, const Frustum& frustum, const std::string& name,
                       ImDrawList& lines) {
    const ImTextureID texture = session.textures.find(name);
    if (texture == nullptr) return;
    ImVec2 corners[4];
    for (std::size_t i = 0; i < 4; ++i) {
        const auto seen = frustum.corners[i] ? sight.project(*frustum.corners[i]) : std::nullopt;
        if (!seen) return;
        corners[i] = on_screen(*seen);
    }
    lines.AddImageQuad(texture, corners[0], corners[1], corners[2], corners[3], {0, 0}, {1, 0}, {1, 1}, {0, 1},
                       IM_COL32(255, 255, 255, 215));
}

void draw_camera_in_world(const Session& session, const Sight& sight, const client::CameraState& camera,
                          std::vector<GripPoint>& grips, ImDrawList& lines) {
    const bool is_chosen = camera.name == session.selected;
    const ImU32 colour = is_chosen ? chosen : camera.mount ? mounted : plain;
    const camera::Pose base = session.pose_of_camera(camera);
    Frustum frustum = frustum_of(camera, base, frustum_m);
    if (camera.ptz) {
        // Seen is what the head makes of it; dragged is where it looks at pan and tilt 0.
        client::CameraState shown = camera;
        shown.intrinsics = camera.shown_intrinsics;
        const glm::dvec3 handle = frustum.handle;
        const camera::Pose known = pose_of(camera.world_pose);
        frustum = frustum_of(shown, {base.position, known.orientation}, frustum_m);
        frustum.handle = handle;
    }
    if (is_chosen) draw_live_picture(session, sight, frustum, camera.name, lines);
    for (const auto& [from, to] : frustum.lines)
        if (const auto line = sight.project(from, to))
            lines.AddLine(on_screen(line->first), on_screen(line->second), colour, is_chosen ? 2.0F : 1.2F);
    const auto apex = sight.project(frustum.apex);
    if (!apex) return;
    lines.AddCircleFilled(on_screen(*apex), 6, colour);
    lines.AddText({static_cast<float>(apex->x) + 9, static_cast<float>(apex->y) - 16}, colour, camera.name.c_str());
    grips.push_back({camera.name, Grip::body, *apex});
    if (!is_chosen || camera.mount) return;
    if (const auto handle = sight.project(frustum.handle)) {
        lines.AddCircle(on_screen(*handle), 7, colour, 0, 2.5F);
        grips.push_back({camera.name, Grip::handle, *handle});
    }
}

void drag(Session& session, const Sight& sight, const std::vector<GripPoint>& grips, bool is_hovered) {
    const ImGuiIO& io = ImGui::GetIO();
    const auto drag_to = [&](ImVec2 mouse) {
        if (const auto* camera = session.model.find(session.drag->camera()))
            session.drag_camera(*camera, session.drag->to(sight.ray(point_of(mouse))));
    };
    if (session.drag && session.released_at) {
        const ImVec2 before{io.MousePos.x - io.MouseDelta.x, io.MousePos.y - io.MouseDelta.y};
        if (session.released_at->x != before.x || session.released_at->y != before.y) drag_to(*session.released_at);
        session.drag.reset();
    }
    if (is_hovered && session.pressed_at) {
        const glm::dvec2 pressed_at = point_of(*session.pressed_at);
        const GripPoint* grip = nearest_grip(grips, pressed_at);
        session.selected = grip ? grip->camera : "";
        if (const auto* camera = session.model.find(session.selected)) {
            const Grip how = grip->grip == Grip::body && io.KeyShift ? Grip::lift : grip->grip;
            session.drag.emplace(camera->name, how, session.pose_of_camera(*camera), sight.ray(pressed_at), frustum_m);
        }
    }
    if (!session.drag) return;
    if (io.MouseDelta.x != 0 || io.MouseDelta.y != 0) drag_to(io.MousePos);
    const bool is_there = session.model.find(session.drag->camera()) != nullptr;
    if (!is_there || !ImGui::IsMouseDown(ImGuiMouseButton_Left)) session.drag.reset();
}

}  // namespace

void draw_scene(Session& session, const Area& area) {
    static Shown shown;  // of the texture: it lives as long
    if (auto world = session.pictures.take_world()) {
        session.textures.put(world_texture, world->picture);
        shown = {world->pose, world->vfov_rad};
    }
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
    begin_panel("world", area);
    ImGui::PopStyleVar();
    ImGui::InvisibleButton("scene", area.extent, ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight);
    const bool is_hovered = ImGui::IsItemHovered();
    steer(session, area, is_hovered);
    if (session.has_looked)
        session.pictures.look(session.fly, {static_cast<int>(area.extent.x), static_cast<int>(area.extent.y)});

    ImDrawList& lines = *ImGui::GetWindowDrawList();
    const ImVec2 end(area.origin.x + area.extent.x, area.origin.y + area.extent.y);
    if (const ImTextureID picture = session.textures.find(world_texture)) lines.AddImage(picture, area.origin, end);
    const Sight sight(shown.pose, shown.vfov_rad, point_of(area.origin), point_of(area.extent));
    std::vector<GripPoint> grips;
    for (const auto& camera : session.model.cameras) draw_camera_in_world(session, sight, camera, grips, lines);
    drag(session, sight, grips, is_hovered);

    const std::string& words = session.model.problem.empty() ? session.model.refused : session.model.problem;
    if (!words.empty()) {
        lines.AddRectFilled(area.origin, {end.x, area.origin.y + 24}, IM_COL32(120, 20, 20, 220));
        lines.AddText({area.origin.x + 8, area.origin.y + 5}, IM_COL32_WHITE, words.c_str());
    }
    ImGui::End();
}

}  // namespace camrig::view
