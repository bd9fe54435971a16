#include "tests/render/support/targets.h"

#include <cmath>
#include <numbers>

namespace camrig::render {
namespace {

constexpr int corners = 64;

glm::dvec3 rim(const Disc& disc, double turn) {
    const double angle = 2.0 * std::numbers::pi * turn;
    return disc.centre + std::cos(angle) * disc.across + std::sin(angle) * disc.up;
}

}  // namespace

std::optional<glm::dvec2> ray_steps(const camera::CameraModel& camera, glm::dvec2 pixel) {
    constexpr double half = 1e-4;
    glm::dvec2 steps;
    for (int axis = 0; axis < 2; ++axis) {
        glm::dvec2 offset(0.0);
        offset[axis] = half;
        const auto before = camera.ray(pixel - offset), after = camera.ray(pixel + offset);
        if (!before || !after) return std::nullopt;
        steps[axis] = glm::length(*after - *before) / (2.0 * half);
    }
    return steps;
}

std::optional<Disc> disc_at(const camera::CameraModel& camera, glm::dvec2 pixel, double distance, double radius_px) {
    const auto ray = camera.ray(pixel);
    const auto steps = ray_steps(camera, pixel);
    if (!ray || !steps) return std::nullopt;
    // The smaller of the two steps: no disc is larger than asked for.
    const double radius = distance * radius_px * std::min(steps->x, steps->y);
    const glm::dvec3 helper = std::abs(ray->y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 across = glm::normalize(glm::cross(helper, *ray));
    return Disc{*ray * distance, across * radius, glm::cross(*ray, across) * radius};
}

TestWorld world_of(const std::vector<Disc>& discs) {
    const auto world_from_optical = [](glm::dvec3 p) { return glm::dvec3(p.z, -p.x, -p.y); };
    world::Material white = colored(glm::vec3(1.0f), true);
    white.double_sided = true;
    TestWorld world;
    std::uint32_t id = 0;
    for (const Disc& disc : discs) {
        // Around its own middle, so that floats hold the outline well.
        std::vector<glm::vec3> points;
        for (int i = 0; i < corners; ++i) {
            points.push_back(glm::vec3(0.0f));
            for (const int j : {i, i + 1}) {
                points.push_back(glm::vec3(world_from_optical(rim(disc, double(j) / corners) - disc.centre)));
            }
        }
        world.objects.push_back(instance_of(model_of(triangles(points), white), world_from_optical(disc.centre), ++id));
    }
    return world;
}

glm::dvec2 exact_centroid(const camera::CameraModel& camera, const Disc& disc) {
    // Each side of the polygon that is drawn, in short pieces: straight in space, bent in the picture.
    constexpr int pieces = 16;
    std::vector<glm::dvec2> outline;
    for (int i = 0; i < corners; ++i) {
        const glm::dvec3 a = rim(disc, double(i) / corners), b = rim(disc, double(i + 1) / corners);
        for (int j = 0; j < pieces; ++j) {
            const auto p = camera.project(glm::mix(a, b, double(j) / pieces));
            if (p) outline.push_back(*p);
        }
    }
    const glm::dvec2 origin = outline.front();
    double area = 0.0;
    glm::dvec2 moment(0.0);
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const glm::dvec2 a = outline[i] - origin, b = outline[(i + 1) % outline.size()] - origin;
        const double cross = a.x * b.y - a.y * b.x;
        area += cross;
        moment += cross * (a + b);
    }
    return origin + moment / (3.0 * area);
}

glm::dvec2 seen_centroid(const Picture& picture, glm::dvec2 near, double reach_px) {
    const ImageSize size = picture.frame->info().size;
    double light = 0.0;
    glm::dvec2 moment(0.0);
    for (int y = std::max(0, int(near.y - reach_px)); y <= std::min(size.height - 1, int(near.y + reach_px)); ++y) {
        for (int x = std::max(0, int(near.x - reach_px)); x <= std::min(size.width - 1, int(near.x + reach_px)); ++x) {
            const double value = linear_of(picture.red(x, y));
            light += value;
            moment += value * (glm::dvec2(x, y) - near);
        }
    }
    return near + moment / light;
}

}  // namespace camrig::render
