#pragma once

#include <imgui.h>

#include "tools/view/session.h"

/// The parts of the window. Each draws itself from the session and changes it; called once a turn, between NewFrame and
/// Render.
namespace camrig::view {

/// The window's parts have fixed places: what is left of it belongs to the world.
inline constexpr float list_width = 260;
inline constexpr float camera_width = 300;
inline constexpr float timeline_height = 170;

struct Area {
    ImVec2 origin;
    ImVec2 extent;
};

/// The world, with the cameras over it: fly, choose, drag.
void draw_scene(Session& session, const Area& area);
/// All cameras with their live pictures; create, duplicate, delete, save.
void draw_camera_list(Session& session, const Area& area);
/// Everything about the chosen camera.
void draw_camera(Session& session, const Area& area);
/// Inside the camera's part: how it fails, and what else it may. `kinds`: as the rig describes them.
void draw_faults(Session& session, const std::string& camera, const nlohmann::json& kinds);
/// Play, pause, step; what actors do and events that fire.
void draw_timeline(Session& session, const Area& area);

/// The question that waits for an answer, if there is one, before all else.
void draw_question(Session& session, const Area& area);

/// A part at its place, which cannot be moved. Ends with ImGui::End().
void begin_panel(const char* title, const Area& area);

}  // namespace camrig::view
