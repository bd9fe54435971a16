#include "tools/view/session.h"

#include <camrig/error.h>

#include "tools/view/arrangement.h"
#include "tools/view/frustum.h"

namespace camrig::view {
namespace {

/// A view from above one end of what there is to see, where no camera shows the way.
const FlyCamera first_look{.position = {-6, -6, 5}, .pan_rad = 0.785, .tilt_rad = -0.5};

constexpr double new_camera_ahead_m = 3;

client::CameraOptions placed_at(const Pose& pose) {
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

Pose Session::pose_of_camera(const client::CameraState& camera) const {
    if (drag && drag->camera() == camera.name)
        if (const auto found = moved.find(camera.name); found != moved.end()) return found->second;
    const auto found = moved.find(camera.name);
    return found != moved.end() ? found->second : pose_of(camera.world_pose);
}

void Session::move_camera(const client::CameraState& camera, const Pose& pose) {
    if (camera.mount) {
        notice = camera.name + " is mounted on " + camera.mount->actor + " and goes where that goes";
        return;
    }
    moved[camera.name] = pose;
    link.set_camera(camera.name, "pose", placed_at(pose));
}

void Session::create_camera() {
    auto names = names_of(model.cameras);
    std::string name = "cam";
    if (std::ranges::find(names, name) != names.end()) name = free_name(name, names);
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
    const std::string name = free_name(camera->name, names_of(model.cameras));
    client::CameraOptions options = camera->options();
    if (!camera->mount) {
        Pose beside = pose_of_camera(*camera);
        beside.position += glm::mat3_cast(beside.orientation) * glm::dvec3(0, -0.6, 0);
        options.position = placed_at(beside).position;
    }
    link.edit("create " + name, [name, options](const client::Rig& rig) { rig.create_camera(name, options); });
    selected = name;
}

void Session::delete_selected() {
    if (selected.empty()) return;
    link.edit("delete " + selected, [name = selected](const client::Rig& rig) { rig.camera(name).remove(); });
    notice = selected + ": deleted";
    selected.clear();
}

void Session::save() {
    // Asked anew, after all edits before it: what is written is what the rig has.
    link.edit("save", [file = arrangement, own = own_camera](const client::Rig& rig) {
        auto done = write_arrangement(file, arrangement_of(rig.call("camera.list"), own));
        if (!done) throw client::Error("unavailable", done.error().message);
    });
    notice = "saved to " + arrangement.string() + "; back with: camrig camera create --file " + arrangement.string();
}

void Session::play_or_pause() {
    link.edit("play",
              [is_paused = model.world.paused](const client::Rig& rig) { is_paused ? rig.resume() : rig.pause(); });
}

void Session::step(std::chrono::nanoseconds how_far) {
    link.edit("step", [how_far](const client::Rig& rig) { rig.step(how_far); });
}

void Session::update() {
    model = link.model();
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
    timeline.update(model);
    pictures.want(names_of(model.cameras));
}

}  // namespace camrig::view
