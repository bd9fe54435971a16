#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <span>

#include "core/camera/lens_traits.h"
#include "tools/view/described_fields.h"
#include "tools/view/panels.h"
#include "tools/view/typed_value.h"

namespace camrig::view {
namespace {

using nlohmann::json;

struct LensPreset {
    const char* name;
    camera::LensModel model;
    std::array<double, 5> coefficients;
    double hfov_deg;             ///< of its pinhole part; 0: stays
    double px_per_rad_of_width;  ///< for fisheyes: focal length by width; 0: not one
};

/// Typical lenses; the coefficients are of a camera of that kind, rounded.
constexpr std::array<LensPreset, 5> presets{{
    {"pinhole", camera::LensModel::pinhole, {}, 0, 0},
    {"webcam, 70 deg", camera::LensModel::plumb_bob, {-0.05, 0.02, 0, 0, 0}, 70, 0},
    {"wide angle, 100 deg", camera::LensModel::plumb_bob, {-0.25, 0.06, 0, 0, -0.006}, 100, 0},
    {"telephoto, 20 deg", camera::LensModel::plumb_bob, {0.03, -0.02, 0, 0, 0}, 20, 0},
    {"fisheye, 180 deg", camera::LensModel::equidistant, {0, 0, 0, 0, 0}, 0, 1 / std::numbers::pi},
}};

client::CameraOptions options_of(const LensPreset& preset, client::Size size) {
    client::CameraOptions options;
    options.lens = client::Lens{};
    options.lens->model = to_string(preset.model);
    options.lens->coefficients.assign(preset.coefficients.begin(),
                                      preset.coefficients.begin() + coefficient_count(preset.model));
    if (preset.hfov_deg > 0) options.hfov_deg = preset.hfov_deg;
    if (preset.px_per_rad_of_width > 0) {
        const double f = size.width * preset.px_per_rad_of_width;
        options.intrinsics = client::Intrinsics{f, f, (size.width - 1) / 2.0, (size.height - 1) / 2.0};
    }
    return options;
}

/// A choice of words; true when another was taken.
bool choose(const char* label, std::span<const char* const> words, int& index) {
    return ImGui::Combo(label, &index, words.data(), static_cast<int>(words.size()));
}

void edit_pose(Session& session, const client::CameraState& camera) {
    if (camera.mount) {
        ImGui::Text("mounted on %s %s", camera.mount->actor.c_str(), camera.mount->node.c_str());
        return;
    }
    const camera::Pose pose = session.pose_of_camera(camera);
    std::array<double, 3> position{pose.position.x, pose.position.y, pose.position.z};
    const camera::PanTiltRoll now = camera::angles_of(pose.orientation);
    std::array<double, 3> angles{};
    for (std::size_t i = 0; i < 3; ++i) {
        const double degrees = std::array{now.pan, now.tilt, now.roll}[i] * 180 / std::numbers::pi;
        angles[i] = std::abs(degrees) < 1e-9 ? 0 : degrees;  // rounding would show as -0.00
    }
    bool is_changed =
        ImGui::InputScalarN("position m", ImGuiDataType_Double, position.data(), 3, nullptr, nullptr, "%.3f");
    is_changed =
        ImGui::InputScalarN("pan tilt roll", ImGuiDataType_Double, angles.data(), 3, nullptr, nullptr, "%.2f") ||
        is_changed;
    if (!is_changed) return;
    const auto rad = [&](std::size_t i) { return angles[i] * std::numbers::pi / 180; };
    if (auto moved = camera::pose_from_angles({position[0], position[1], position[2]}, {rad(0), rad(1), rad(2)}))
        session.move_camera(camera, *moved);
}

void edit_picture(Session& session, const client::CameraState& camera) {
    auto vfov_deg = static_cast<float>(camera.vfov_deg);
    const auto lens_model = parse_name<camera::LensModel>(camera.lens.model);
    const bool has_view_angle = !lens_model || !sees_behind(*lens_model);
    if (has_view_angle && ImGui::SliderFloat("field of view", &vfov_deg, 5, 140, "%.1f deg")) {
        client::CameraOptions options;
        options.vfov_deg = vfov_deg;
        options.zoom = camera.zoom;
        session.link.set_camera(camera.name, "vfov", options);
    }
    static constexpr std::array rates{"1", "5", "10", "15", "24", "25", "30000/1001", "30", "50", "60"};
    static const std::array<client::Rate, 10> values{1, 5, 10, 15, 24, 25, client::Rate(30000, 1001), 30, 50, 60};
    int rate = -1;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (values[i] == camera.fps) rate = static_cast<int>(i);
    if (choose("frames/s", rates, rate)) {
        client::CameraOptions options;
        options.fps = values[static_cast<std::size_t>(rate)];
        session.link.set_camera(camera.name, "fps", options);
    }
    static constexpr std::array sizes{"320x240", "640x480", "1280x720", "1920x1080"};
    static constexpr std::array<client::Size, 4> pixels{{{320, 240}, {640, 480}, {1280, 720}, {1920, 1080}}};
    int size = -1;
    for (std::size_t i = 0; i < pixels.size(); ++i)
        if (pixels[i] == camera.size) size = static_cast<int>(i);
    if (choose("size", sizes, size)) {
        client::CameraOptions options;
        options.size = pixels[static_cast<std::size_t>(size)];
        session.link.set_camera(camera.name, "size", options);
    }
    std::array<const char*, presets.size()> names{};
    for (std::size_t i = 0; i < presets.size(); ++i) names[i] = presets[i].name;
    int lens = camera.lens.model == "pinhole" ? 0 : -1;
    if (choose("lens", names, lens)) {
        client::CameraOptions options = options_of(presets[static_cast<std::size_t>(lens)], camera.size);
        if (options.hfov_deg || options.intrinsics) options.zoom = camera.zoom;
        session.link.set_camera(camera.name, "lens", options);
    }
}

/// The camera as camera.list tells it; null before that.
const json* settings_of(const Session& session, const std::string& camera) {
    if (!session.model.settings) return nullptr;
    const json& list = session.model.settings->at("cameras");
    const auto found = std::ranges::find_if(list, [&](const json& one) { return one.at("name") == camera; });
    return found == list.end() ? nullptr : &*found;
}

void set(Session& session, const std::string& camera, const std::string& key, json params) {
    params["name"] = camera;
    session.link.edit(camera + "/" + key,
                      [params = std::move(params)](const client::Rig& rig) { rig.call("camera.set", params); });
}

/// The parameters that have no control of their own above.
void edit_described(Session& session, const json& fields, const json& camera) {
    ImGui::PushID("described");  // some have the name of a control above
    draw_described(fields, camera, [&](json wish) {
        std::string key = wish.begin().key();
        const bool is_optics = key == "intrinsics" || key.ends_with("fov_deg");
        // A change that waits gives way to a later one of the same thing, not of another part of it.
        if (const json& value = wish.begin().value(); value.is_object() && !value.empty())
            key += "/" + value.begin().key();
        // Optics are what they are at the zoom that is given with them.
        if (is_optics) wish["zoom"] = camera.at("zoom");
        set(session, camera.at("name"), key, std::move(wish));
    });
    ImGui::PopID();
}

std::string words_of(const json& output) {
    std::string words = output.at("kind");
    for (const auto& [key, value] : output.items())
        if (key != "kind") words += " " + key + " " + text_of(value);
    return words;
}

void edit_outputs(Session& session, const json& kinds, const json& camera) {
    ImGui::TextUnformatted("outputs beside HTTP");
    json outputs = camera.at("outputs");
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        if (ImGui::SmallButton("x")) {
            outputs.erase(i);
            set(session, camera.at("name"), "outputs", {{"outputs", outputs}});
            ImGui::PopID();
            return;
        }
        ImGui::SameLine();
        ImGui::TextUnformatted(words_of(outputs[i]).c_str());
        ImGui::PopID();
    }
    for (const json& kind : kinds) {
        const std::string name = kind.at("name");
        if (!ImGui::TreeNode(("new " + name).c_str())) continue;
        static std::map<std::string, json> drafts;
        json& draft = drafts.try_emplace(name, json{{"kind", name}}).first->second;
        json shown = draft;
        for (const json& field : kind.at("fields")) {
            const std::string key = field.at("name");
            if (field.at("type").get<std::string>().starts_with('[')) continue;  // has no control yet
            if (!shown.contains(key)) shown[key] = empty_value(field);
            // What nobody has touched stays out, for the rig has its defaults; but not what it must be told.
            if (field.contains("required")) draft[key] = shown[key];
        }
        draw_described(kind.at("fields"), shown, [&](const json& wish) { draft.update(wish); });
        if (ImGui::SmallButton("add")) {
            outputs.push_back(draft);
            set(session, camera.at("name"), "outputs", {{"outputs", outputs}});
        }
        ImGui::TreePop();
    }
}

}  // namespace

void draw_camera(Session& session, const Area& area) {
    begin_panel("camera", area);
    if (const auto* camera = session.model.find(session.selected)) {
        ImGui::TextUnformatted(camera->name.c_str());
        ImGui::SameLine();
        ImGui::TextDisabled("%dx%d at %.4g/s, %d watching", camera->size.width, camera->size.height,
                            camera->fps.hertz(), static_cast<int>(camera->readers));
        ImGui::PushItemWidth(190);
        edit_pose(session, *camera);
        edit_picture(session, *camera);
        ImGui::PopItemWidth();
        const json description = session.link.description();
        if (const json* settings = settings_of(session, camera->name); settings && !description.is_null()) {
            ImGui::PushItemWidth(150);
            edit_outputs(session, description.at("outputs"), *settings);
            draw_faults(session, camera->name, description.at("faults"));
            ImGui::Separator();
            edit_described(session, description.at("camera"), *settings);
            ImGui::PopItemWidth();
        }
    } else {
        ImGui::TextWrapped(
            "Click a camera to choose it. Drag its dot over the ground, with Shift up and down; drag the ring to turn "
            "it. "
            "Fly with W A S D, Q E and the right mouse button; the wheel goes ahead.");
    }
    ImGui::End();
}

}  // namespace camrig::view
