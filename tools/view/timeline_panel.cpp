#include <algorithm>
#include <chrono>
#include <functional>

#include "tools/view/panels.h"

namespace camrig::view {
namespace {

using namespace std::chrono_literals;

constexpr float name_width = 110;
constexpr float row_height = 15;

/// One colour for a word, always the same.
ImU32 colour_of(const std::string& word) {
    const auto hue = static_cast<float>(std::hash<std::string>{}(word) % 360) / 360.0F;
    return ImColor::HSV(hue, 0.5F, 0.65F);
}

void draw_transport(Session& session) {
    const client::WorldStatus& world = session.model.world;
    const bool is_lockstep = world.mode == "lockstep";
    ImGui::BeginDisabled(is_lockstep);
    if (ImGui::Button(world.paused ? "Play (Space)" : "Pause (Space)", {110, 0})) session.play_or_pause();
    ImGui::EndDisabled();
    ImGui::SameLine();
    ImGui::BeginDisabled(!is_lockstep && !world.paused);
    for (const auto& [label, how_far] :
         {std::pair{"+0.04 s", 40ms}, std::pair{"+0.2 s", 200ms}, std::pair{"+1 s", 1000ms}}) {
        if (ImGui::Button(label)) session.step(how_far);
        ImGui::SameLine();
    }
    ImGui::EndDisabled();
    ImGui::Text("%.2f s   %s   %s%s   %d actors", static_cast<double>(world.world_ns) / 1e9, world.scene.c_str(),
                world.mode.c_str(), world.paused ? ", paused" : "", static_cast<int>(world.actors));
}

/// Where a world time is; the present is at the right.
struct Axis {
    float left, right;
    std::int64_t now_ns;
    float at(std::int64_t time_ns) const {
        const auto ago = static_cast<float>(now_ns - time_ns) / static_cast<float>(Timeline::span_ns);
        return std::clamp(right - ago * (right - left), left, right);
    }
};

void draw_firings(const Session& session, const Axis& axis, float top, ImDrawList& lines) {
    lines.AddText({axis.left - name_width, top}, IM_COL32(255, 220, 120, 255), "events");
    float free_from = axis.left;
    for (const Firing& firing : session.model.firings) {
        if (firing.world_ns < axis.now_ns - Timeline::span_ns || firing.world_ns > axis.now_ns) continue;
        const float x = axis.at(firing.world_ns);
        lines.AddLine({x, top}, {x, top + row_height - 2}, IM_COL32(255, 220, 120, 255), 2);
        if (ImGui::IsMouseHoveringRect({x - 4, top}, {x + 4, top + row_height}))
            ImGui::SetTooltip("%.2f s: %s %s", static_cast<double>(firing.world_ns) / 1e9, firing.event.c_str(),
                              firing.actor.c_str());
        if (x < free_from) continue;  // its word would lie on the one before
        lines.AddText({x + 3, top}, IM_COL32(255, 220, 120, 255), firing.event.c_str());
        free_from = x + 10 + ImGui::CalcTextSize(firing.event.c_str()).x;
    }
}

void draw_actor(const std::string& name, const std::deque<Doing>& doings, const Axis& axis, float top,
                ImDrawList& lines) {
    lines.AddText({axis.left - name_width, top}, IM_COL32(210, 210, 210, 255), name.c_str());
    for (const Doing& doing : doings) {
        const float from = axis.at(doing.from_ns), to = axis.at(doing.to_ns);
        lines.AddRectFilled({from, top + 1}, {std::max(to, from + 1), top + row_height - 1}, colour_of(doing.what));
        if (ImGui::CalcTextSize(doing.what.c_str()).x < to - from - 4)
            lines.AddText({from + 3, top}, IM_COL32_WHITE, doing.what.c_str());
    }
}

}  // namespace

void draw_timeline(Session& session, const Area& area) {
    begin_panel("time", area);
    draw_transport(session);
    ImGui::BeginChild("rows");
    ImDrawList& lines = *ImGui::GetWindowDrawList();
    const ImVec2 origin = ImGui::GetCursorScreenPos();
    const Axis axis{origin.x + name_width, origin.x + ImGui::GetContentRegionAvail().x - 8, session.timeline.now_ns()};
    draw_firings(session, axis, origin.y, lines);
    float top = origin.y + row_height;
    for (const auto& [name, doings] : session.timeline.actors()) {
        draw_actor(name, doings, axis, top, lines);
        top += row_height;
    }
    ImGui::Dummy({1, top - origin.y});  // what can be scrolled
    ImGui::EndChild();
    ImGui::End();
}

}  // namespace camrig::view
