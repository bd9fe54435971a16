#include "core/render/software/projected_rows.h"

#include <algorithm>
#include <optional>

#include "core/render/software/depth_of_pixels.h"
#include "core/render/software/pyramid_sampling.h"
#include "core/world/backdrop/backdrop.h"

namespace camrig::render::software {
namespace {

/// A photo that is larger than the view shows that it is.
constexpr int rows_of_samples = 2;
constexpr std::uint32_t black = 0xFFu << 24;

/// Beyond its edges a picture goes on as at the edge.
void to_edge(int& x, int& y, ImageSize size) {
    x = std::clamp(x, 0, size.width - 1);
    y = std::clamp(y, 0, size.height - 1);
}

/// From points of the view's optical frame to places in the picture.
class Projector {
public:
    Projector(const world::ProjectedPicture& by, const camera::Pose& view) : by_(by) {
        const glm::dmat3 taker_from_world = glm::transpose(camera::world_from_optical_rotation(by.pose));
        turn_ = taker_from_world * camera::world_from_optical_rotation(view);
        shift_ = taker_from_world * (view.position - by.pose.position);
    }

    glm::dvec3 of_point(const glm::dvec3& p) const { return turn_ * p + shift_; }
    glm::dvec3 of_direction(const glm::dvec3& d) const { return turn_ * d; }

    /// seen_at(dx, dy): as of_point or of_direction, of the pixel so far away. has_left, has_upper: there are pixels on
    /// these sides.
    template <typename SeenAt>
    std::uint32_t look_up(bool has_left, bool has_upper, const SeenAt& seen_at) const {
        const auto at = by_.camera.project(seen_at(0, 0));
        if (!at) return black;
        // A pixel beside may see nothing, and then looks another way: of both sides the shorter step counts.
        const auto step = [&](bool has_other_side, int dx, int dy) {
            const auto next = by_.camera.project(seen_at(dx, dy));
            const glm::dvec2 there = next ? *next - *at : glm::dvec2(dx, dy);
            if (!has_other_side || glm::length(there) <= 1.0) return there;
            const auto before = by_.camera.project(seen_at(-dx, -dy));
            const glm::dvec2 back = before ? *at - *before : there;
            return glm::length(back) < glm::length(there) ? back : there;
        };
        // Far beyond the edge all is as at the edge, and whole numbers of pixels stay within theirs.
        const auto [width, height] = by_.camera.size();
        const glm::dvec2 near = glm::clamp(*at, glm::dvec2(-width, -height), glm::dvec2(2 * width, 2 * height));
        return code_of(
            sampled(*by_.picture, {near, step(has_left, 1, 0), step(has_upper, 0, 1)}, to_edge, rows_of_samples));
    }

private:
    const world::ProjectedPicture& by_;
    glm::dmat3 turn_;
    glm::dvec3 shift_;
};

/// ray_at(x, y): of the view's optical frame. numbers: as of draw_projected.
template <typename RayAt>
void lay(const ViewWork& work, const ViewGeometry& geometry, std::uint32_t proxies, const PixelRect& rect,
         Rows<std::uint32_t> numbers, const RayAt& ray_at) {
    const Projector projector(*work.backdrop->projected, work.view->pose);
    const bool is_lens = geometry.rays() != nullptr;
    std::uint32_t plane_of = 0;
    DepthOfPixels plane;
    for (int y = rect.y0; y < rect.y1; ++y) {
        std::uint32_t* const to = work.canvas.color(y);
        for (int x = rect.x0; x < rect.x1; ++x) {
            const std::uint32_t number = numbers(y)[x];
            if (number > proxies || work.canvas.depth(y)[x] == blind_depth) continue;
            if (number == 0) {
                to[x] = projector.look_up(
                    x > 0, y > 0, [&](int dx, int dy) { return projector.of_direction(ray_at(x + dx, y + dy)); });
                continue;
            }
            if (number != plane_of) plane = depth_of(geometry, geometry.triangles()[number - 1]);
            plane_of = number;
            to[x] = projector.look_up(x > 0, y > 0, [&](int dx, int dy) {
                const int px = x + dx, py = y + dy;
                const glm::dvec3 ray = ray_at(px, py);
                const double across = is_lens ? ray.x * plane.right + ray.y * plane.down + ray.z * plane.ahead
                                              : px * plane.right + py * plane.down + plane.ahead;
                const double times = plane.offset / across;
                // Seen from its edge a triangle may have no depth there.
                return projector.of_point(
                    ray * (times > plane.nearest ? std::min<double>(times, plane.farthest) : plane.nearest));
            });
        }
    }
}

}  // namespace

void draw_projected(const ViewWork& work, const ViewGeometry& geometry, std::uint32_t proxies, const PixelRect& rect,
                    Rows<std::uint32_t> numbers) {
    const camera::Intrinsics& k = work.view->spec->intrinsics;
    if (work.rays == nullptr)
        return lay(work, geometry, proxies, rect, numbers,
                   [&](int x, int y) { return glm::dvec3((x - k.cx) / k.fx, (y - k.cy) / k.fy, 1.0); });
    const LensRays::Coordinates rays = work.rays->rays();
    lay(work, geometry, proxies, rect, numbers,
        [&](int x, int y) { return glm::dvec3(rays.x(y)[x], rays.y(y)[x], rays.z(y)[x]); });
}

}  // namespace camrig::render::software
