#include "core/world/model_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/base/names.h"
#include "core/base/portable_math.h"
#include "core/world/model_lights.h"
#include "core/world/scene_reader.h"
#include "core/world/shape_model.h"

namespace camrig::world {
namespace {

struct Sphere {
    glm::dvec3 center{0.0};
    double radius = 1.0;
    double lowest_z = 0.0;
};

/// Around all vertices in the pose the first picture shows.
Sphere bounds_of(const Model& model, const PosedModel& pose) {
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    std::vector<glm::vec3> positions, normals;
    for (const int index : model.order) {
        const int mesh = model.nodes[static_cast<std::size_t>(index)].mesh;
        if (mesh < 0) continue;
        for (const Primitive& primitive : model.meshes[static_cast<std::size_t>(mesh)].primitives) {
            positions.resize(primitive.positions.size());
            normals.resize(primitive.positions.size());
            deform_vertices(model, pose, index, primitive, positions, normals);
            for (const glm::vec3& p : positions) {
                low = glm::min(low, glm::dvec3(p));
                high = glm::max(high, glm::dvec3(p));
            }
        }
    }
    const double radius = glm::length(high - low) / 2.0;
    if (!std::isfinite(radius)) return {};
    return {(low + high) / 2.0, std::max(radius, 1e-3), low.z};
}

Result<CameraSpec> framing_camera(const Sphere& bounds) {
    constexpr double vfov = 60.0 * 3.14159265358979323846 / 180.0;
    const double distance = 1.1 * bounds.radius / portable::sin(vfov / 2.0);
    // glTF's front (+z) is -y here; a little from the right and above shows depth.
    const glm::dvec3 eye = bounds.center + distance * glm::normalize(glm::dvec3(0.5, -1.0, 0.4));
    auto pose = camera::pose_look_at(eye, bounds.center);
    if (!pose) return std::unexpected(pose.error());
    CameraSpec spec;
    spec.name = "main";
    CameraPatch patch;
    patch.pose = *pose;
    patch.optics = VerticalFov{vfov};
    spec.near_m = std::min(0.05, (distance - bounds.radius) / 2.0);
    return patch_camera_spec(spec, patch);
}

/// "Front Door.001" -> "front_door_001"; a number makes it unique.
std::string camera_name(const std::string& wish, std::set<std::string>& taken) {
    std::string name;
    for (const char c : wish.substr(0, max_name_length)) {
        const bool upper = c >= 'A' && c <= 'Z';
        const bool plain = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
        name += upper ? static_cast<char>(c - 'A' + 'a') : plain ? c : '_';
    }
    if (name.empty()) name = "camera";
    std::string unique = name;
    for (int n = 2; !taken.insert(unique).second; ++n) {
        const std::string suffix = "_" + std::to_string(n);
        unique = name.substr(0, max_name_length - suffix.size()) + suffix;
    }
    return unique;
}

/// A glTF camera looks along -z of its node with +y up; a body frame has x forward, y left, z up.
Result<camera::Pose> camera_pose(const glm::dmat4& world_from_node) {
    const glm::dvec3 back(world_from_node[2]), up(world_from_node[1]);
    const glm::dvec3 left = glm::cross(-up, back);
    if (!(glm::length(back) > 0.0) || !(glm::length(left) > 0.0))
        return error(ErrorKind::invalid_argument, "a camera's node is scaled to nothing");
    const glm::dvec3 x = -glm::normalize(back), y = glm::normalize(left);
    return camera::pose_from_quaternion(glm::dvec3(world_from_node[3]),
                                        glm::quat_cast(glm::dmat3(x, y, glm::cross(x, y))));
}

Result<CameraSpec> model_camera(const ModelCamera& from, const glm::dmat4& world_from_node, std::string name) {
    auto pose = camera_pose(world_from_node);
    if (!pose) return std::unexpected(pose.error());
    CameraSpec spec;
    spec.name = std::move(name);
    CameraPatch patch;
    patch.pose = *pose;
    patch.optics = VerticalFov{from.yfov_rad};
    spec.near_m = from.near_m;
    if (from.aspect > 0.0) {
        const double width =
            std::clamp(480.0 * from.aspect, double{min_image_size.width}, double{max_image_size.width});
        patch.size = ImageSize{static_cast<int>(std::lround(width)), 480};
    }
    return patch_camera_spec(spec, patch);
}

Light default_sun() {
    Light sun;
    sun.name = "sun";
    sun.intensity = 0.7f;
    sun.direction = glm::normalize(glm::dvec3(-0.4, 0.7, -1.0));
    return sun;
}

/// The power of ten at or below `size`, which is 0.01 or more.
double grid_of(double size) {
    double grid = 0.01;
    while (grid * 10.0 <= size) grid *= 10.0;
    return grid;
}

/// As large as the model asks for; all in proportion, as files come in metres, millimetres and miles.
void add_ground_and_sky(const Sphere& bounds, Scene& scene) {
    const double size = std::clamp(bounds.radius, 0.01, 1e7);
    GroundShape ground;
    ground.size = glm::dvec2(40.0 * size);
    ground.grid_m = grid_of(size);
    scene.models["ground"].model = shape_model(ground);
    scene.models["sky"].model = shape_model(SkyShape{.radius_m = 60.0 * size});
    ObjectSpec floor;
    floor.name = floor.model = floor.object_class = "ground";
    // A floor of the file's own that is its lowest part is not fought with.
    floor.position = {bounds.center.x, bounds.center.y, bounds.lowest_z - 0.002 * bounds.radius};
    ObjectSpec sky;
    sky.name = sky.model = sky.object_class = "sky";
    sky.position = bounds.center;
    scene.objects.push_back(std::move(floor));
    scene.objects.push_back(std::move(sky));
}

}  // namespace

Result<Scene> scene_of_model(ModelRef model, const SceneOptions& options) {
    Scene scene;
    scene.name = model->name;
    scene.description = "a bare model";
    ObjectSpec object;
    object.name = object.model = "model";
    if (!model->animations.empty()) object.clip = model->animations.front().name;
    scene.models["model"].model = model;
    scene.objects.push_back(object);
    append_model_lights(*model, object, scene.lights);
    if (scene.lights.size() > max_scene_lights)
        return error(ErrorKind::resource_exhausted, "more than " + std::to_string(max_scene_lights) + " lights");
    if (scene.lights.empty()) scene.lights.push_back(default_sun());

    PosedModel pose;
    const ClipState first{};
    const bool moves = !object.clip.empty();
    pose_model(*model, moves ? std::span(&first, 1) : std::span<const ClipState>{}, pose);
    const Sphere bounds = bounds_of(*model, pose);
    if (options.bare_ground) add_ground_and_sky(bounds, scene);
    std::set<std::string> taken;
    for (const int index : model->order) {
        const Node& node = model->nodes[static_cast<std::size_t>(index)];
        if (node.camera < 0 || scene.cameras.size() >= max_scene_cameras) continue;
        const ModelCamera& from = model->cameras[static_cast<std::size_t>(node.camera)];
        if (!from.perspective) continue;
        auto camera = model_camera(from, pose.model_from_node[static_cast<std::size_t>(index)],
                                   camera_name(from.name.empty() ? node.name : from.name, taken));
        if (!camera) return at("cameras." + from.name, camera.error());
        scene.cameras.push_back(std::move(*camera));
    }
    if (!scene.cameras.empty()) return scene;
    auto camera = framing_camera(bounds);
    if (!camera) return std::unexpected(camera.error());
    scene.cameras.push_back(std::move(*camera));
    return scene;
}

}  // namespace camrig::world
