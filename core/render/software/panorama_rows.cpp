#include "core/render/software/panorama_rows.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/portable_math.h"
#include "core/world/backdrop/backdrop.h"
#include "core/world/backdrop/panorama.h"

namespace camrig::render::software {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double most_samples = 16.0;

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

/// The picture at a place in pixels, centres at integers; beyond the top and the bottom is the other side of the pole.
glm::dvec3 bilinear(const world::Image& picture, double u, double v) {
    const auto& linear = linear_of_code();
    const auto [width, height] = picture.size;
    const double column = std::floor(u), row = std::floor(v);
    const double right = u - column, below = v - row;
    const auto texel = [&](int x, int y) {
        if (y < 0 || y >= height) {
            y = y < 0 ? -1 - y : 2 * height - 1 - y;
            x += width / 2;
        }
        x %= width;
        if (x < 0) x += width;
        const std::uint8_t* const at =
            picture.rgba.data() +
            4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
        return glm::dvec3(linear[at[0]], linear[at[1]], linear[at[2]]);
    };
    const int x = static_cast<int>(column), y = static_cast<int>(row);
    return (1.0 - below) * ((1.0 - right) * texel(x, y) + right * texel(x + 1, y)) +
           below * ((1.0 - right) * texel(x, y + 1) + right * texel(x + 1, y + 1));
}

/// What of the largest level a pixel sees: its middle, and its steps to the next pixel on the right and below.
struct Footprint {
    glm::dvec2 at, dx, dy;
};

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

/// Of a number of at least 1: how often it can be halved, and between two powers of two evenly.
double halvings_of(double number) {
    int exponent = 0;
    const double share = std::frexp(number, &exponent);
    return exponent - 1 + (2.0 * share - 1.0);
}

glm::dvec3 seen(const world::Panorama& panorama, const Footprint& of) {
    const double x2 = glm::dot(of.dx, of.dx), y2 = glm::dot(of.dy, of.dy);
    const double longer = std::sqrt(std::max(x2, y2)), shorter = std::sqrt(std::min(x2, y2));
    if (longer <= 1.0) return bilinear(panorama.levels[0], of.at.x, of.at.y);
    const double wide = std::max({shorter, longer / most_samples, 1.0});
    const double level = std::min(halvings_of(wide), static_cast<double>(panorama.levels.size() - 1));
    const auto fine = static_cast<std::size_t>(level);
    const double coarse_share = level - static_cast<double>(fine);
    const int samples = static_cast<int>(std::clamp(std::ceil(longer / wide), 1.0, most_samples));
    const glm::dvec2& along = x2 >= y2 ? of.dx : of.dy;
    glm::dvec3 sum(0.0);
    const auto add = [&](std::size_t number, double share) {
        const world::Image& picture = panorama.levels[number];
        const ImageSize whole = panorama.levels[0].size;
        const glm::dvec2 scale(static_cast<double>(picture.size.width) / whole.width,
                               static_cast<double>(picture.size.height) / whole.height);
        for (int i = 0; i < samples; ++i) {
            const glm::dvec2 place = (of.at + along * ((i + 0.5) / samples - 0.5) + 0.5) * scale - 0.5;
            sum += share / samples * bilinear(picture, place.x, place.y);
        }
    };
    add(fine, 1.0 - coarse_share);
    if (coarse_share > 0.0) add(fine + 1, coarse_share);
    return sum;
}

std::uint32_t code_of(const glm::dvec3& light) {
    const auto code = [](double channel) { return std::uint32_t{srgb_code(static_cast<float>(channel))}; };
    return code(light.r) | code(light.g) << 8 | code(light.b) << 16 | 0xFFu << 24;
}

}  // namespace

void draw_panorama(const ViewWork& work, const PixelRect& rect) {
    const world::CameraSpec& spec = *work.view->spec;
    const world::Panorama& panorama = *work.backdrop->panorama;
    const camera::Intrinsics& k = spec.intrinsics;
    // Rows of a matrix that turns the panorama's middle to +x.
    const double yaw = work.backdrop->yaw_rad, c = portable::cos(yaw), s = portable::sin(yaw);
    const glm::dmat3 panorama_from_world(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
    const glm::dmat3 turn = panorama_from_world * camera::world_from_optical_rotation(work.view->pose);
    const auto draw = [&](int y, auto ray_at) {
        for (int x = rect.x0; x < rect.x1; ++x) {
            const glm::dvec3 ray = ray_at(x, y);
            work.canvas.color(y)[x] =
                code_of(seen(panorama, footprint_of(turn * ray, turn * (ray_at(x + 1, y) - ray),
                                                    turn * (ray_at(x, y + 1) - ray), panorama.levels[0].size)));
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
