#include "core/render/software/panorama_rows.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/portable_math.h"
#include "core/render/software/panorama_sampling.h"
#include "core/world/backdrop/backdrop.h"

namespace camrig::render::software {
namespace {

constexpr double pi = std::numbers::pi;

/// Within 3e-9: half a hundred thousandth of a pixel of the largest panorama. Many times faster than portable::atan2.
double quick_atan2(double y, double x) {
    constexpr double tan_of_eighth = 0.41421356237309503;  // of pi / 8
    const double a = std::abs(y), b = std::abs(x);
    const bool is_steep = a > b;
    const double low = is_steep ? b : a, high = is_steep ? a : b;
    if (high == 0.0) return 0.0;
    double t = low / high, base = 0.0;
    if (t > tan_of_eighth) {
        t = (t - 1.0) / (t + 1.0);
        base = pi / 4.0;
    }
    const double s = t * t;
    // The series of atan, to t^17.
    double sum = 1.0 / 17.0;
    for (int k = 15; k >= 1; k -= 2) sum = 1.0 / k - s * sum;
    double angle = base + t * sum;
    if (is_steep) angle = pi / 2.0 - angle;
    if (x < 0.0) angle = pi - angle;
    return y < 0.0 ? -angle : angle;
}

Footprint footprint_of(const glm::dvec3& ray, const glm::dvec3& dx, const glm::dvec3& dy, ImageSize size) {
    const double q2 = std::max(ray.x * ray.x + ray.y * ray.y, 1e-24), q = std::sqrt(q2), r2 = q2 + ray.z * ray.z;
    const double per_rad_x = size.width / (2.0 * pi), per_rad_y = size.height / pi;
    // Azimuth grows to the left, elevation to the top.
    const auto step = [&](const glm::dvec3& d) {
        const double along = ray.x * d.x + ray.y * d.y;
        return glm::dvec2(-(ray.x * d.y - ray.y * d.x) / q2 * per_rad_x,
                          -(q2 * d.z - ray.z * along) / (q * r2) * per_rad_y);
    };
    return {{(pi - quick_atan2(ray.y, ray.x)) * per_rad_x - 0.5, (0.5 * pi - quick_atan2(ray.z, q)) * per_rad_y - 0.5},
            step(dx),
            step(dy)};
}

}  // namespace

void draw_panorama(const ViewWork& work, const PixelRect& rect) {
    const world::CameraSpec& spec = *work.view->spec;
    const world::Panorama& panorama = *work.backdrop->panorama;
    const ImageSize size = panorama.whole.levels.front().size;
    const camera::Intrinsics& k = spec.intrinsics;
    // Rows of a matrix that turns the panorama's middle to +x.
    const double yaw = work.backdrop->yaw_rad, c = portable::cos(yaw), s = portable::sin(yaw);
    const glm::dmat3 panorama_from_world(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
    const glm::dmat3 turn = panorama_from_world * camera::world_from_optical_rotation(work.view->pose);
    const auto draw = [&](int y, auto ray_at) {
        for (int x = rect.x0; x < rect.x1; ++x) {
            const glm::dvec3 ray = ray_at(x, y);
            work.canvas.color(y)[x] =
                code_of(sampled(panorama, footprint_of(turn * ray, turn * (ray_at(x + 1, y) - ray),
                                                       turn * (ray_at(x, y + 1) - ray), size)));
        }
    };
    for (int y = rect.y0; y < rect.y1; ++y) {
        if (work.rays == nullptr) {
            draw(y, [&](int px, int py) { return glm::dvec3((px - k.cx) / k.fx, (py - k.cy) / k.fy, 1.0); });
        } else {
            const LensRays::Coordinates rays = work.rays->rays();
            draw(y, [&](int px, int py) { return glm::dvec3(rays.x(py)[px], rays.y(py)[px], rays.z(py)[px]); });
        }
    }
}

}  // namespace camrig::render::software
