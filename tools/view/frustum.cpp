#include "tools/view/frustum.h"

#include <algorithm>

#include "core/camera/camera_model.h"

namespace camrig::view {
namespace {

constexpr int pieces_per_side = 8;

Result<camera::CameraModel> model_of(const client::CameraState& camera) {
    auto model = parse_name<camera::LensModel>(camera.lens.model);
    if (!model) return std::unexpected(model.error());
    camera::Lens lens{.model = *model};
    std::ranges::copy_n(
        camera.lens.coefficients.begin(),
        static_cast<std::ptrdiff_t>(std::min(camera.lens.coefficients.size(), lens.coefficients.size())),
        lens.coefficients.begin());
    const client::Intrinsics& k = camera.intrinsics;
    return camera::CameraModel::create({camera.size.width, camera.size.height}, {k.fx, k.fy, k.cx, k.cy}, lens);
}

}  // namespace

camera::Pose pose_of(const client::Pose& pose) {
    const auto& q = pose.orientation;
    return {{pose.position[0], pose.position[1], pose.position[2]}, glm::dquat(q[3], q[0], q[1], q[2])};
}

Frustum frustum_of(const client::CameraState& camera, const camera::Pose& pose, double depth_m) {
    const glm::dmat3 world_from_optical = world_from_optical_rotation(pose);
    Frustum frustum;
    frustum.apex = pose.position;
    frustum.handle = pose.position + world_from_optical * glm::dvec3(0, 0, depth_m);
    const auto model = model_of(camera);
    if (!model) return frustum;

    const double width = camera.size.width, height = camera.size.height;
    const std::array<glm::dvec2, 4> pixels{
        {{-0.5, -0.5}, {width - 0.5, -0.5}, {width - 0.5, height - 0.5}, {-0.5, height - 0.5}}};
    const auto place = [&](glm::dvec2 pixel) -> std::optional<glm::dvec3> {
        const auto ray = model->ray(pixel);
        if (!ray) return std::nullopt;
        // To a plane before a camera that sees like a pinhole; to a sphere beyond 60 degrees from its axis.
        const double reach = ray->z > 0.5 ? depth_m / ray->z : depth_m * 2;
        return pose.position + world_from_optical * (*ray * reach);
    };
    for (std::size_t side = 0; side < 4; ++side) {
        const glm::dvec2 from = pixels[side], to = pixels[(side + 1) % 4];
        std::optional<glm::dvec3> before = place(from);
        frustum.corners[side] = before;
        if (before) frustum.lines.emplace_back(frustum.apex, *before);
        for (int i = 1; i <= pieces_per_side; ++i) {
            const auto next = place(glm::mix(from, to, static_cast<double>(i) / pieces_per_side));
            if (before && next) frustum.lines.emplace_back(*before, *next);
            before = next;
        }
    }
    return frustum;
}

}  // namespace camrig::view
