#include "core/render/view_motion.h"

#include <algorithm>
#include <cmath>

#include "core/camera/camera_model.h"
#include "core/world/posed_model.h"

namespace camrig::render {
namespace {

constexpr int grid_px = 8;
/// What is moved further is out of the picture.
constexpr double most_px = 1e4;

bool is_as(const world::Instance& a, const world::Instance& b) {
    return a.info == b.info && a.position == b.position && a.orientation == b.orientation && a.scale == b.scale &&
           a.clips == b.clips;
}

void find_moving(ViewMotion& motion) {
    const auto& [begin, middle, end] = motion.moments;
    const auto add_unlike = [&](const world::Snapshot& a, const world::Snapshot& b) {
        for (const world::Instance& one : a.movers) {
            const auto other = std::ranges::find(b.movers, one.info, &world::Instance::info);
            if (other == b.movers.end() || !is_as(one, *other)) motion.moving.push_back(one.info->id);
        }
    };
    // Of what comes or goes meanwhile too.
    for (const auto* one : {&begin.snapshot, &end.snapshot}) {
        add_unlike(**one, *middle.snapshot);
        add_unlike(*middle.snapshot, **one);
    }
    std::ranges::sort(motion.moving);
    motion.moving.erase(std::ranges::unique(motion.moving).begin(), motion.moving.end());
}

void find_flickers(const world::Snapshot& snapshot, std::vector<double>& hz) {
    for (const world::Light& light : snapshot.statics->lights)
        if (light.flicker_depth > 0.0f && light.intensity > 0.0f && std::ranges::find(hz, light.flicker_hz) == hz.end())
            hz.push_back(light.flicker_hz);
}

/// Where a camera of that moment sees points of the world.
struct Eye {
    camera::CameraModel model;
    glm::dmat3 optical_from_world;
    glm::dvec3 position;

    std::optional<glm::dvec2> see(const glm::dvec3& world) const {
        return model.project(optical_from_world * (world - position));
    }
    std::optional<glm::dvec2> see_direction(const glm::dvec3& world) const {
        return model.project(optical_from_world * world);
    }
};

Eye eye_at(const View& view, const camera::CameraState& state) {
    const View then = view_at(view, state);
    const world::CameraSpec& spec = *then.spec;
    return {camera::CameraModel::create(spec.size, spec.intrinsics, spec.lens).value(),
            glm::transpose(camera::world_from_optical_rotation(then.pose)), then.pose.position};
}

/// The model's nodes and the corners of what hangs on them, in the world.
void add_points(const world::Instance& instance, world::PosedModel& pose, std::vector<glm::dvec3>& points) {
    const world::Model& model = *instance.info->model;
    world::pose_model(model, instance.clips, pose);
    const auto add = [&](const glm::dvec3& at) {
        points.push_back(instance.position + instance.orientation * (instance.scale * at));
    };
    for (const int n : model.order) {
        const auto i = static_cast<std::size_t>(n);
        const glm::dmat4& node = pose.model_from_node[i];
        add(glm::dvec3(node[3]));
        if (model.nodes[i].mesh < 0 || world::is_deformed(model, n)) continue;
        for (const world::Primitive& primitive :
             model.meshes[static_cast<std::size_t>(model.nodes[i].mesh)].primitives) {
            if (world::look_of(instance.info->look, primitive.material).is_hidden) continue;
            for (int corner = 0; corner < 8; ++corner) {
                const world::Box& box = primitive.bounds;
                const glm::dvec3 at((corner & 1) != 0 ? box.max.x : box.min.x,
                                    (corner & 2) != 0 ? box.max.y : box.min.y,
                                    (corner & 4) != 0 ? box.max.z : box.min.z);
                add(glm::dvec3(node * glm::dvec4(at, 1.0)));
            }
        }
    }
}

/// Of nodes from low to high: with what hangs on them, and the ground that is dark below them.
PixelRect around(glm::dvec2 low, glm::dvec2 high, ImageSize size) {
    const double reach = 4.0 + 0.25 * std::max(high.x - low.x, high.y - low.y);
    const auto within = [](double at, int end) { return static_cast<int>(std::clamp(at, 0.0, double{1} * end)); };
    return {within(low.x - reach, size.width), within(low.y - reach, size.height), within(high.x + reach, size.width),
            within(high.y + reach, size.height)};
}

}  // namespace

std::optional<ViewMotion> motion_of(const View& view, const sensor::RowTimes& times) {
    if (view.past == nullptr) return std::nullopt;
    ViewMotion motion{.times = times, .moments = {}, .moving = {}, .flicker_hz = {}};
    // What is further back is not known; what is seen of the rest stands for it.
    const TimeNs end_ns = times.end_ns();
    motion.times.exposure_ns =
        std::min(times.exposure_ns, world::CameraPast::span_ns - (times.rows - 1) * times.row_ns);
    motion.times.begin_ns = end_ns - (motion.times.end_ns() - motion.times.begin_ns);
    const TimeNs begin_ns = motion.times.begin_ns;
    motion.moments = {view.past->at(begin_ns), view.past->at(begin_ns + (end_ns - begin_ns) / 2),
                      view.past->at(end_ns)};
    const auto& [begin, middle, end] = motion.moments;
    const auto is_same_state = [](const camera::CameraState& a, const camera::CameraState& b) {
        return a.pose == b.pose && a.intrinsics == b.intrinsics;
    };
    motion.camera_moves = !is_same_state(begin.state, middle.state) || !is_same_state(middle.state, end.state);
    motion.statics_change =
        begin.snapshot->statics != middle.snapshot->statics || middle.snapshot->statics != end.snapshot->statics;
    find_moving(motion);
    for (const auto& moment : motion.moments) find_flickers(*moment.snapshot, motion.flicker_hz);
    if (!motion.camera_moves && !motion.statics_change && motion.moving.empty() && motion.flicker_hz.empty())
        return std::nullopt;
    return motion;
}

ViewMotion standing_still(const View& view, const sensor::RowTimes& times, const world::SnapshotRef& instant) {
    ViewMotion motion{.times = times, .moments = {}, .moving = {}, .flicker_hz = {}};
    camera::CameraState state;
    state.pose = view.pose;
    state.intrinsics = view.spec->intrinsics;
    motion.moments.fill({instant, state});
    return motion;
}

View view_at(const View& view, const camera::CameraState& state) {
    View then = view;
    then.pose = state.pose;
    if (view.spec->lens.model == camera::LensModel::pinhole && state.intrinsics != view.spec->intrinsics) {
        auto zoomed = std::make_shared<world::CameraSpec>(*view.spec);
        zoomed->intrinsics = state.intrinsics;
        then.spec = std::move(zoomed);
    }
    return then;
}

bool needs_depth(const ViewMotion& motion) {
    const auto& [begin, middle, end] = motion.moments;
    return begin.state.pose.position != middle.state.pose.position ||
           middle.state.pose.position != end.state.pose.position;
}

MovedPixels moved_pixels(const ViewMotion& motion, const View& view, const frame::Frame* depth) {
    const auto& [begin, middle, end] = motion.moments;
    const Eye eye = eye_at(view, middle.state);
    const std::array<Eye, 3> eyes = motion.camera_moves
                                        ? std::array{eye_at(view, begin.state), eye, eye_at(view, end.state)}
                                        : std::array{eye, eye, eye};
    const ImageSize size = view.spec->size;
    MovedPixels moved{.most = motion.statics_change ? most_px : 0.0, .movers = {}};
    using Places = std::array<std::optional<glm::dvec2>, 3>;
    const auto way_of = [](const Places& at) {
        double way = 0.0;
        for (std::size_t i = 1; i < at.size(); ++i)
            if (at[i] && at[i - 1]) way += glm::distance(*at[i], *at[i - 1]);
        return std::min(way, most_px);
    };
    const auto consider = [&](const Places& at) { moved.most = std::max(moved.most, way_of(at)); };
    if (motion.camera_moves) {
        const auto* const metres = depth != nullptr ? reinterpret_cast<const float*>(depth->bytes().data()) : nullptr;
        for (int y = 0; y < size.height; y += std::min(grid_px, std::max(1, size.height - 1 - y))) {
            for (int x = 0; x < size.width; x += std::min(grid_px, std::max(1, size.width - 1 - x))) {
                const auto ray = eyes[1].model.ray({x, y});
                if (!ray) continue;
                const glm::dvec3 towards = glm::transpose(eyes[1].optical_from_world) * *ray;
                const double z = metres != nullptr ? metres[std::ptrdiff_t{y} * size.width + x] : INFINITY;
                if (!std::isfinite(z) || ray->z <= 0.0) {
                    consider({eyes[0].see_direction(towards), glm::dvec2(x, y), eyes[2].see_direction(towards)});
                } else {
                    const glm::dvec3 at = eyes[1].position + towards * (z / ray->z);
                    consider({eyes[0].see(at), glm::dvec2(x, y), eyes[2].see(at)});
                }
            }
        }
    }
    world::PosedModel pose;
    std::array<std::vector<glm::dvec3>, 3> points;
    for (const ObjectId id : motion.moving) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            points[i].clear();
            for (const world::Instance& instance : motion.moments[i].snapshot->movers)
                if (instance.info->id == id) add_points(instance, pose, points[i]);
        }
        // Large things reach out of the picture with all of their corners; what does not touch it moves nothing.
        glm::dvec2 low(INFINITY), high(-INFINITY);
        double way = 0.0;
        bool is_seen_whole = true;
        for (std::size_t k = 0; k < std::min({points[0].size(), points[1].size(), points[2].size()}); ++k) {
            const Places at{eyes[0].see(points[0][k]), eyes[1].see(points[1][k]), eyes[2].see(points[2][k])};
            for (const auto& one : at) {
                is_seen_whole &= one.has_value();
                if (!one) continue;
                low = glm::min(low, *one);
                high = glm::max(high, *one);
            }
            way = std::max(way, way_of(at));
        }
        // Of what is partly behind the camera nobody can tell where the rest of it shows.
        const bool touches =
            low.x <= high.x &&
            (!is_seen_whole || (low.x < size.width && low.y < size.height && high.x >= 0.0 && high.y >= 0.0));
        if (touches) moved.most = std::max(moved.most, way);
        moved.movers.push_back({.id = id,
                                .px = touches ? way : 0.0,
                                .rect = is_seen_whole && low.x <= high.x ? around(low, high, size)
                                                                         : PixelRect{0, 0, size.width, size.height}});
    }
    return moved;
}

}  // namespace camrig::render
