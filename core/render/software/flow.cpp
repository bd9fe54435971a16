#include "core/render/software/flow.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/render/software/depth_of_pixels.h"
#include "core/render/software/lens_rays.h"
#include "core/render/software/surface_point.h"
#include "core/render/software/view_work.h"

namespace camrig::render::software {
namespace {

/// A triangle whose pixels are followed.
class FollowedTriangle {
public:
    FollowedTriangle(const ViewGeometry& geometry, const SceneAhead& ahead, const ScreenTriangle& triangle)
        : geometry_(geometry),
          camera_(ahead.camera()),
          draw_(ahead.draw(triangle.draw)),
          depth_(depth_of(geometry, triangle)) {
        if (draw_.positions == nullptr) return;
        const ViewDraw& draw = geometry.draws()[triangle.draw];
        now_ = corners_of(geometry, triangle);
        for (std::size_t i = 0; i < 3; ++i) {
            const Corner corner = corner_of(geometry, draw, triangle.vertices[i]);
            const glm::vec3& local =
                corner.clipped != nullptr ? corner.clipped->local_ahead : draw_.positions[corner.vertex];
            then_[i] = glm::dvec3(draw_.from_local * glm::dvec4(local, 1.0));
        }
    }

    glm::dvec2 flow_at(int x, int y) const {
        if (draw_.is_still) return glm::dvec2(0.0);
        const auto seen = draw_.is_there ? camera_.project(then_of(point_at(x, y))) : std::nullopt;
        return seen ? *seen - glm::dvec2(x, y) : glm::dvec2(std::numeric_limits<double>::quiet_NaN());
    }

private:
    glm::dvec3 point_at(int x, int y) const {
        const camera::Intrinsics& k = geometry_.transform().intrinsics;
        glm::dvec3 ray((x - k.cx) / k.fx, (y - k.cy) / k.fy, 1.0), across(x, y, 1.0);
        if (const LensRays* const rays = geometry_.rays()) {
            const LensRays::Coordinates of = rays->rays();
            across = ray = {of.x(y)[x], of.y(y)[x], of.z(y)[x]};
        }
        const double along = depth_.offset / glm::dot(across, glm::dvec3(depth_.right, depth_.down, depth_.ahead));
        // Seen from its edge it may have no depth there.
        return ray * std::min(std::max(along, double{depth_.nearest}), double{depth_.farthest});
    }

    glm::dvec3 then_of(const glm::dvec3& point) const {
        if (draw_.positions == nullptr) return glm::dvec3(draw_.from_now * glm::dvec4(point, 1.0));
        const glm::dvec3 second = now_[1] - now_[0], third = now_[2] - now_[0], from = point - now_[0];
        const glm::dvec3 normal = glm::cross(second, third);
        const double area2 = glm::dot(normal, normal);
        if (!(area2 > 0.0)) return then_[0];
        // Corners are rounded to parts of a pixel: what is drawn may lie a little beside them.
        const double b = std::clamp(glm::dot(glm::cross(from, third), normal) / area2, 0.0, 1.0);
        const double c = std::clamp(glm::dot(glm::cross(second, from), normal) / area2, 0.0, 1.0 - b);
        return then_[0] + b * (then_[1] - then_[0]) + c * (then_[2] - then_[0]);
    }

    const ViewGeometry& geometry_;
    const camera::CameraModel& camera_;
    const SceneAhead::Draw& draw_;
    DepthOfPixels depth_;
    std::array<glm::dvec3, 3> now_{}, then_{};  ///< corners of what is deformed
};

}  // namespace

void SceneAhead::find_firsts(const scene::PlacedScene& scene, Firsts& firsts) {
    firsts.clear();
    for (const bool is_static : {true, false})
        for (const scene::PlacedSurface& surface : scene.group_of(is_static).all())
            firsts.try_emplace(surface.object->id, &surface);
}

void SceneAhead::begin(const scene::PlacedScene& now, const world::CameraSpec& spec, const ViewTransform& view,
                       const world::CameraPast::Moment& then) {
    now_ = &now;
    scene_.place(then.snapshot);
    view_ = view;
    view_then_ = make_view_transform(then.state.pose, spec.size, then.state.intrinsics, spec.near_m, spec.far_m);
    camera_stands_ = view_then_.eye == view_.eye && view_then_.optical_from_world == view_.optical_from_world &&
                     then.state.intrinsics == spec.intrinsics;
    camera_ = camera::CameraModel::create(spec.size, then.state.intrinsics, spec.lens).value();
    find_firsts(now, firsts_now_);
    find_firsts(scene_, firsts_then_);
}

const scene::PlacedSurface* SceneAhead::then_of(const scene::SeenSurface& seen) const {
    const scene::PlacedSurface& placed = *seen.placed;
    const auto all_now = now_->group_of(seen.is_static).all();
    if (placed.index >= all_now.size() || &all_now[placed.index] != &placed) return &placed;
    const auto first = firsts_now_.find(placed.object->id), first_then = firsts_then_.find(placed.object->id);
    if (first == firsts_now_.end() || first_then == firsts_then_.end()) return nullptr;
    // The surfaces of an object stand one after the other, in the order of its model.
    const scene::PlacedSurface& begin = *first_then->second;
    const std::size_t index = begin.index + (placed.index - first->second->index);
    const auto all = scene_.statics().all();
    const bool is_static_then = begin.index < all.size() && &all[begin.index] == &begin;
    const auto then = scene_.group_of(is_static_then).all();
    if (index >= then.size()) return nullptr;
    const scene::PlacedSurface& found = then[index];
    return found.object->id == placed.object->id && found.primitive == placed.primitive ? &found : nullptr;
}

const glm::vec3* SceneAhead::positions_of(const scene::SeenSurface& seen) {
    const scene::PlacedSurface* const then = then_of(seen);
    if (then == nullptr || then == seen.placed || then->deformation < 0) return nullptr;
    const auto all = scene_.statics().all();
    const bool is_static = then->index < all.size() && &all[then->index] == then;
    return (is_static ? scene_.statics() : scene_.movers())
        .deform(*then, scene::LevelSet{1} << seen.level)
        .positions.data();
}

void SceneAhead::follow(std::span<const ViewDraw> draws) {
    draws_.clear();
    for (const ViewDraw& draw : draws) {
        Draw& ahead = draws_.emplace_back();
        const scene::PlacedSurface* const then = then_of(draw);
        if (then == nullptr) continue;
        ahead.is_there = true;
        ahead.positions = draw.positions_ahead;
        ahead.from_local = view_then_.optical_from(then->world_from_local);
        if (ahead.positions != nullptr) continue;
        ahead.is_still = camera_stands_ && then->world_from_local == draw.placed->world_from_local;
        ahead.from_now = ahead.from_local * glm::inverse(draw.optical_from_local);
    }
}

void describe_flow(const ViewScratch& scratch, const PixelRect& rect, ViewWork& work) {
    const ViewGeometry& geometry = scratch.geometry;
    frame::Frame& frame = *work.channels[index_of(frame::FrameKind::flow)].frame;
    auto* const pixels = reinterpret_cast<float*>(frame.mutable_bytes().data());
    const Rows<std::uint32_t> numbers = scratch.numbers.rows();
    std::uint32_t last = 0;
    std::optional<FollowedTriangle> triangle;
    for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0; x < rect.x1; ++x) {
            const std::uint32_t number = numbers(y)[x];
            if (number == 0) continue;
            if (number != last) triangle.emplace(geometry, *work.ahead, geometry.triangles()[number - 1]);
            last = number;
            const glm::dvec2 flow = triangle->flow_at(x, y);
            float* const to = pixels + std::ptrdiff_t{2} * (std::ptrdiff_t{y} * frame.info().size.width + x);
            to[0] = static_cast<float>(flow.x);
            to[1] = static_cast<float>(flow.y);
        }
    }
}

}  // namespace camrig::render::software
