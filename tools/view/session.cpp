#include "tools/view/session.h"

#include <algorithm>
#include <memory>
#include <system_error>
#include <utility>

#include <camrig/error.h>

#include "tools/view/arrangement.h"
#include "tools/view/frustum.h"

namespace camrig::view {
namespace {

/// A view from above one end of what there is to see, where no camera shows the way.
const FlyCamera first_look{.position = {-6, -6, 5}, .pan_rad = 0.785, .tilt_rad = -0.5};

constexpr double new_camera_ahead_m = 3;

client::CameraOptions placed_at(const camera::Pose& pose) {
    client::CameraOptions options;
    const auto& q = pose.orientation;
    options.position = {pose.position.x, pose.position.y, pose.position.z};
    options.orientation = {q.x, q.y, q.z, q.w};
    return options;
}

std::vector<std::string> names_of(const std::vector<client::CameraState>& cameras) {
    std::vector<std::string> names;
    for (const auto& camera : cameras) names.push_back(camera.name);
    return names;
}

}  // namespace

camera::Pose Session::pose_of_camera(const client::CameraState& camera) const {
    if (drag && drag->camera() == camera.name)
        if (const auto found = moved.find(camera.name); found != moved.end()) return found->second;
    const auto found = moved.find(camera.name);
    // Of one on a head it is that of the base, which is what can be placed.
    return found != moved.end() ? found->second : pose_of(camera.mount ? camera.world_pose : camera.pose);
}

void Session::move_camera(const client::CameraState& camera, const camera::Pose& pose) {
    if (camera.mount) {
        notice = camera.name + " is mounted on " + camera.mount->actor + " and goes where that goes";
        return;
    }
    moved[camera.name] = pose;
    link.set_camera(camera.name, "pose", placed_at(pose));
}

void Session::drag_camera(const client::CameraState& camera, const camera::Pose& pose) {
    // The first move of a drag: afterwards `moved` has the camera.
    if (!camera.mount && drag && !drag->has_moved()) {
        remember(camera.name + ": back where it was", [this, name = camera.name, before = pose_of_camera(camera)] {
            if (const auto* found = model.find(name)) move_camera(*found, before);
        });
        drag->set_moved();
    }
    move_camera(camera, pose);
}

std::string Session::unused(std::string name) const {
    std::vector<std::string> tried;
    // First whether one is about to be made: when it no longer is, the model has it.
    while (link.is_pending("create " + name) || link.model().find(name) != nullptr) {
        tried.push_back(name);
        name = free_name(name, tried);
    }
    return name;
}

void Session::create_camera() {
    const std::string name = unused("cam");
    // Before the eye, or it could be neither seen nor dragged.
    FlyCamera place = fly;
    place.go(new_camera_ahead_m, 0, 0);
    link.edit("create " + name,
              [name, pose = place.pose()](const client::Rig& rig) { rig.create_camera(name, placed_at(pose)); });
    selected = name;
    notice = name + ": made before you; drag it to its place";
}

void Session::duplicate_selected() {
    const auto* camera = model.find(selected);
    if (camera == nullptr) return;
    const std::string name = unused(camera->name);
    client::CameraOptions options = camera->options();
    if (!camera->mount) {
        camera::Pose beside = pose_of_camera(*camera);
        beside.position += glm::mat3_cast(beside.orientation) * glm::dvec3(0, -0.6, 0);
        options.position = placed_at(beside).position;
    }
    link.edit("create " + name, [name, options](const client::Rig& rig) { rig.create_camera(name, options); });
    selected = name;
}

void Session::delete_selected() {
    if (selected.empty()) return;
    question = {.words = "Delete camera " + selected + "? Its streams and devices end.",
                .yes = "Delete",
                .act = [this, name = selected] { delete_camera(name); }};
}

void Session::delete_camera(const std::string& name) {
    // Filled and used by edits, which are done one after the other on the link's thread.
    const auto camera = std::make_shared<nlohmann::json>();
    link.edit("delete " + name, [name, camera](const client::Rig& rig) {
        *camera = rig.call("camera.get", {{"name", name}});
        rig.camera(name).remove();
    });
    remember(name + ": there again", [this, name, camera] {
        link.edit("create " + name, [camera](const client::Rig& rig) { rig.call("camera.create", *camera); });
    });
    notice = name + ": deleted; Ctrl+Z brings it back";
    if (selected == name) selected.clear();
}

void Session::answer(bool is_yes) {
    const auto asked = std::exchange(question, std::nullopt);
    if (asked && is_yes) asked->act();
}

void Session::remember(std::string words, std::function<void()> act) {
    if (undos_.size() == max_undos) undos_.pop_front();
    undos_.push_back({std::move(words), std::move(act)});
}

void Session::undo() {
    if (undos_.empty()) {
        notice = "there is nothing to undo";
        return;
    }
    const Undo last = std::move(undos_.back());
    undos_.pop_back();
    last.act();
    notice = last.words;
}

void Session::save() {
    std::error_code ignored;
    if (!std::filesystem::exists(arrangement, ignored)) return write_file();
    question = {.words = arrangement.string() + " is there already. Overwrite it?", .yes = "Overwrite", .act = [this] {
                    write_file();
                }};
}

void Session::write_file() {
    // Asked anew, after all edits before it: what is written is what the rig has.
    link.edit("save", [this, file = arrangement, own = own_camera](const client::Rig& rig) {
        auto done = write_arrangement(file, arrangement_of(rig.call("camera.list"), own));
        if (!done) {
            link.tell("not saved to " + file.string());
            throw client::Error("unavailable", done.error().message);
        }
        link.tell("saved to " + file.string() + "; back with: camrig camera create --file " + file.string() +
                  " --replace");
    });
}

void Session::play_or_pause() {
    link.edit("play",
              [is_paused = model.world.paused](const client::Rig& rig) { is_paused ? rig.resume() : rig.pause(); });
}

void Session::step(std::chrono::nanoseconds how_far) {
    link.order([how_far](const client::Rig& rig) { rig.step(how_far); });
}

void Session::update() {
    model = link.model();
    if (auto told = link.take_told()) notice = std::move(*told);
    if (!has_looked && model.problem.empty()) {
        fly = model.cameras.empty() ? first_look : FlyCamera::at(pose_of(model.cameras.front().world_pose));
        has_looked = true;
        if (!model.cameras.empty()) fly.go(-2.5, 0, 0.5);
    }
    std::erase_if(moved, [&](const auto& item) {
        const bool is_held = drag && drag->camera() == item.first;
        return !is_held && !link.is_pending(item.first + "/pose");
    });
    for (const auto& [name, picture] : pictures.take_small()) textures.put(name, picture);
    std::vector<std::string> shown = names_of(model.cameras);
    shown.emplace_back(world_texture);
    textures.keep_only(shown);
    timeline.update(model);
    pictures.want(names_of(model.cameras));
}

}  // namespace camrig::view
