#include "core/render/software/projected_rows.h"

#include <algorithm>
#include <optional>

#include "core/render/software/depth_of_pixels.h"
#include "core/render/software/pyramid_sampling.h"
#include "core/world/backdrop/backdrop.h"

namespace camrig::render::software {
namespace {

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

    std::uint32_t of_point(const glm::dvec3& p, const glm::dvec3& on_the_right, const glm::dvec3& below) const {
        return looked_up(turn_ * p + shift_, turn_ * on_the_right + shift_, turn_ * below + shift_);
    }
    std::uint32_t of_direction(const glm::dvec3& d, const glm::dvec3& on_the_right, const glm::dvec3& below) const {
        return looked_up(turn_ * d, turn_ * on_the_right, turn_ * below);
    }

private:
    std::uint32_t looked_up(const glm::dvec3& p, const glm::dvec3& on_the_right, const glm::dvec3& below) const {
        const auto at = by_.camera.project(p);
        if (!at) return black;
        const glm::dvec2 right = by_.camera.project(on_the_right).value_or(*at + glm::dvec2(1.0, 0.0));
        const glm::dvec2 down = by_.camera.project(below).value_or(*at + glm::dvec2(0.0, 1.0));
        // Far beyond the edge all is as at the edge, and whole numbers of pixels stay within theirs.
        const auto [width, height] = by_.camera.size();
        const glm::dvec2 near = glm::clamp(*at, glm::dvec2(-width, -height), glm::dvec2(2 * width, 2 * height));
        return code_of(sampled(*by_.picture, {near, right - *at, down - *at}, to_edge));
    }

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
            const glm::dvec3 ray = ray_at(x, y), right = ray_at(x + 1, y), below = ray_at(x, y + 1);
            if (number == 0) {
                to[x] = projector.of_direction(ray, right, below);
                continue;
            }
            if (number != plane_of) plane = depth_of(geometry, geometry.triangles()[number - 1]);
            plane_of = number;
            const auto hit = [&](const glm::dvec3& along, int px, int py) {
                const double across = is_lens ? along.x * plane.right + along.y * plane.down + along.z * plane.ahead
                                              : px * plane.right + py * plane.down + plane.ahead;
                const double times = plane.offset / across;
                // Seen from its edge a triangle may have no depth there.
                return along * (times > plane.nearest ? std::min<double>(times, plane.farthest) : plane.nearest);
            };
            to[x] = projector.of_point(hit(ray, x, y), hit(right, x + 1, y), hit(below, x, y + 1));
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
