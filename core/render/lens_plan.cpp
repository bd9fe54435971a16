#include "core/render/lens_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <system_error>
#include <thread>

namespace camrig::render {
namespace {

/// Texels around what the pixels' own places need: a 4x4 filter reads one to the left and two to the right.
constexpr int border = 3;
/// A single plane is not taken beyond this tangent of the angle to the axis (85 deg).
constexpr double max_tangent = 11.4;
/// Directions far behind a fisheye fill many pixels each; the source follows up to so many texels for one in the
/// middle, which is enough to 118 deg from the axis. Further on the face behind would be the largest of all.
constexpr double max_density = 2.5;
/// Rounding must not make a texel larger than a pixel.
constexpr double density_margin = 1.0 + 1e-9;
/// The plane is preferred until it has this many times the texels of the cube: each face costs a pass over the scene.
constexpr double plane_preference = 1.5;
/// Below this many texels of the plane to a pixel, faces are not even tried.
constexpr std::int64_t mild_ratio = 3;
constexpr unsigned max_threads = 4;

/// Rays of all pixels, row by row; zero where the lens shows nothing.
std::vector<glm::dvec3> rays_of(const camera::CameraModel& camera) {
    const auto [width, height] = camera.size();
    std::vector<glm::dvec3> rays(static_cast<std::size_t>(camera.size().pixels()), glm::dvec3(0.0));
    const unsigned threads = std::clamp(std::thread::hardware_concurrency(), 1u, max_threads);
    const auto fill = [&](unsigned first) {
        for (int y = static_cast<int>(first); y < height; y += static_cast<int>(threads)) {
            for (int x = 0; x < width; ++x) {
                if (const auto ray = camera.ray({x, y})) rays[static_cast<std::size_t>(y) * width + x] = *ray;
            }
        }
    };
    std::vector<std::jthread> others;
    try {
        while (others.size() + 1 < threads) others.emplace_back(fill, static_cast<unsigned>(others.size() + 1));
    } catch (const std::system_error&) {  // there is no other thread to be had
    }
    fill(0);
    for (auto i = static_cast<unsigned>(others.size() + 1); i < threads; ++i) fill(i);
    return rays;
}

/// Frames of the faces: the camera's own axis first, then the four around it and the one behind. The sides all have
/// their x axis pointing backwards, so they all need the same part of their plane.
struct Face {
    glm::dmat3 tile_from_optical;
};
Face face_towards(glm::dvec3 z, glm::dvec3 x) {
    const glm::dvec3 y = glm::cross(z, x);
    return {glm::transpose(glm::dmat3(x, y, z))};
}
std::array<Face, 6> cube_faces() {
    const glm::dvec3 back(0, 0, -1);
    return {Face{glm::dmat3(1.0)},         face_towards({1, 0, 0}, back),  face_towards({-1, 0, 0}, back),
            face_towards({0, 1, 0}, back), face_towards({0, -1, 0}, back), face_towards(back, {-1, 0, 0})};
}

/// The face a direction belongs to; ties go to the first.
int face_of(const glm::dvec3& ray) {
    const glm::dvec3 a = glm::abs(ray);
    if (ray.z > 0.0 && ray.z >= a.x && ray.z >= a.y) return 0;
    if (a.x >= a.y && a.x >= a.z) return ray.x > 0.0 ? 1 : 2;
    if (a.y >= a.z) return ray.y > 0.0 ? 3 : 4;
    return 5;
}

glm::dvec2 on_plane(const glm::dmat3& tile_from_optical, const glm::dvec3& ray) {
    const glm::dvec3 p = tile_from_optical * ray;
    return glm::dvec2(p) / p.z;
}

/// How many pixels the sides of a unit square of the plane are long, where one pixel is `right` wide and `down` high.
glm::dvec2 sides_in_pixels(glm::dvec2 right, glm::dvec2 down) {
    const double area = std::abs(right.x * down.y - right.y * down.x);
    return glm::dvec2(std::hypot(right.y, down.y), std::hypot(right.x, down.x)) / area;
}

/// What of the planes the pixels need.
class Survey {
public:
    struct Box {
        glm::dvec2 low{std::numeric_limits<double>::infinity()};
        glm::dvec2 high{-std::numeric_limits<double>::infinity()};
        bool is_used() const { return low.x <= high.x; }
        void add(glm::dvec2 p, glm::dvec2 reach) {
            low = glm::min(low, p - reach);
            high = glm::max(high, p + reach);
        }
    };
    /// Where a pixel looks, and its steps to the right and down, on the plane of its face.
    struct Place {
        int face = -1;  ///< -1: nowhere
        glm::dvec2 at{0.0};
        glm::dvec2 right{0.0};
        glm::dvec2 down{0.0};
    };

    Survey(const camera::CameraModel& camera, std::span<const glm::dvec3> rays, bool is_cube)
        : camera_(camera), rays_(rays), faces_(cube_faces()), is_cube_(is_cube) {}

    /// False if the plane does not hold every ray.
    bool measure() {
        const auto [width, height] = camera_.size();
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                const Place place = place_of(x, y);
                if (place.face < 0) continue;
                if (!is_cube_ && !(std::max(std::abs(place.at.x), std::abs(place.at.y)) < max_tangent)) return false;
                boxes_[place.face].add(place.at, 0.5 * (glm::abs(place.right) + glm::abs(place.down)));
                glm::dvec2& focal = focals_[place.face];
                focal = glm::max(focal, glm::min(sides_in_pixels(place.right, place.down), most_));
            }
        }
        return true;
    }

    Place place_of(int x, int y) const {
        const glm::dvec3& ray = ray_at(x, y);
        if (ray == glm::dvec3(0.0)) return {};
        Place place{.face = is_cube_ ? face_of(ray) : 0};
        if (!is_cube_ && ray.z <= 1.0 / (2.0 * max_tangent)) {
            place.at = glm::dvec2(2.0 * max_tangent);
            return place;
        }
        place.at = on_plane(faces_[place.face].tile_from_optical, ray);
        place.right = step(place, x, y, 1, 0);
        place.down = step(place, x, y, 0, 1);
        return place;
    }

    const std::array<Face, 6>& faces() const { return faces_; }
    const Box& box(int face) const { return boxes_[face]; }
    /// Texels per unit of the face's plane, so that no side of a texel is longer than a pixel.
    glm::dvec2 focal(int face) const { return focals_[face] * density_margin; }
    bool is_cube() const { return is_cube_; }

private:
    const glm::dvec3& ray_at(int x, int y) const {
        return rays_[static_cast<std::size_t>(y) * camera_.size().width + static_cast<std::size_t>(x)];
    }

    /// To the next pixel, or from the last one where there is no next; that of the middle where there is neither. Next
    /// to a fold the steps are as long as can be, hence the bound.
    glm::dvec2 step(const Place& place, int x, int y, int dx, int dy) const {
        const ImageSize size = camera_.size();
        const camera::Intrinsics& k = camera_.intrinsics();
        for (const int sign : {1, -1}) {
            const int nx = x + sign * dx, ny = y + sign * dy;
            if (nx < 0 || ny < 0 || nx >= size.width || ny >= size.height) continue;
            const glm::dvec3& ray = ray_at(nx, ny);
            if (ray == glm::dvec3(0.0)) continue;
            const glm::dvec3 p = faces_[place.face].tile_from_optical * ray;
            if (p.z <= 0.05) continue;
            const glm::dvec2 found = (glm::dvec2(p) / p.z - place.at) * static_cast<double>(sign);
            const double pixels = std::max(std::abs(found.x * k.fx), std::abs(found.y * k.fy));
            return found * std::min(1.0, LensPlan::max_footprint / pixels);
        }
        return glm::dvec2(dx / k.fx, dy / k.fy);
    }

    const camera::CameraModel& camera_;
    std::span<const glm::dvec3> rays_;
    std::array<Face, 6> faces_;
    bool is_cube_;
    std::array<Box, 6> boxes_{};
    std::array<glm::dvec2, 6> focals_{};
    glm::dvec2 most_{max_density * std::max(camera_.intrinsics().fx, camera_.intrinsics().fy)};
};

SourceTile tile_of(const Survey& survey, int face, const camera::CameraModel& camera) {
    const Survey::Box& box = survey.box(face);
    const glm::dvec2 focal = survey.focal(face);
    SourceTile tile{.tile_from_optical = survey.faces()[face].tile_from_optical};
    // On the camera's own plane, texels lie on pixels about the principal point as far as the lens lets them: nothing
    // is blurred there.
    const glm::dvec2 ratio = focal / glm::dvec2(camera.intrinsics().fx, camera.intrinsics().fy);
    const glm::dvec2 zero = survey.is_cube()
                                ? glm::dvec2(0.0)
                                : ratio * (glm::dvec2(camera.intrinsics().cx, camera.intrinsics().cy) + 0.5) - 0.5;
    const glm::dvec2 first = glm::floor(focal * box.low + zero) - static_cast<double>(border);
    const glm::dvec2 last = glm::ceil(focal * box.high + zero) + static_cast<double>(border);
    const auto bounded = [](double side) { return static_cast<int>(std::min(side, 1e6)); };
    tile.size = {bounded(last.x - first.x + 1.0), bounded(last.y - first.y + 1.0)};
    tile.intrinsics = {focal.x, focal.y, zero.x - first.x, zero.y - first.y};
    return tile;
}

/// Puts the tiles on shelves, the highest first, in a source about as wide as high.
ImageSize pack(std::vector<SourceTile>& tiles, int max_side) {
    std::ranges::stable_sort(tiles, std::greater<>{}, [](const SourceTile& tile) { return tile.size.height; });
    double texels = 0.0;
    for (const SourceTile& tile : tiles) texels += static_cast<double>(tile.size.width) * tile.size.height;
    const int shelf_width = static_cast<int>(std::min(1.2 * std::sqrt(texels), static_cast<double>(max_side)));
    ImageSize source;
    int x = 0, y = 0, shelf_height = 0;
    for (SourceTile& tile : tiles) {
        if (x > 0 && x + tile.size.width > shelf_width) {
            y += shelf_height;
            x = shelf_height = 0;
        }
        tile.x = x;
        tile.y = y;
        x += tile.size.width;
        shelf_height = std::max(shelf_height, tile.size.height);
        source.width = std::max(source.width, x);
        source.height = std::max(source.height, y + tile.size.height);
    }
    return source;
}

LensPlan layout(const Survey& survey, const camera::CameraModel& camera, const LensPlanLimits& limits) {
    LensPlan plan;
    plan.method = survey.is_cube() ? world::LensMethod::cube : world::LensMethod::warp;
    plan.size = camera.size();
    for (int face = 0; face < 6; ++face) {
        if (survey.box(face).is_used()) plan.tiles.push_back(tile_of(survey, face, camera));
    }
    plan.source = pack(plan.tiles, limits.max_side);
    return plan;
}

bool fits(const LensPlan& plan, const LensPlanLimits& limits) {
    return std::max(plan.source.width, plan.source.height) <= limits.max_side &&
           plan.source.pixels() <= limits.max_texels;
}

std::int64_t texels_of(const LensPlan& plan) {
    std::int64_t texels = 0;
    for (const SourceTile& tile : plan.tiles) texels += tile.size.pixels();
    return texels;
}

void fill_map(LensPlan& plan, const Survey& survey) {
    std::array<const SourceTile*, 6> tile_of_face{};
    for (const SourceTile& tile : plan.tiles) {
        for (int face = 0; face < 6; ++face) {
            if (survey.faces()[face].tile_from_optical == tile.tile_from_optical) tile_of_face[face] = &tile;
        }
    }
    constexpr double one = 1 << LensPlan::fraction_bits;
    const auto count = static_cast<std::size_t>(plan.size.pixels());
    plan.map.assign(count, LensPlan::nowhere);
    plan.footprint.assign(count, glm::vec4(0.0f));
    if (survey.is_cube()) plan.depth_factor.assign(count, 1.0f);
    for (int y = 0; y < plan.size.height; ++y) {
        for (int x = 0; x < plan.size.width; ++x) {
            const Survey::Place place = survey.place_of(x, y);
            if (place.face < 0) continue;
            const std::size_t i = static_cast<std::size_t>(y) * plan.size.width + static_cast<std::size_t>(x);
            const SourceTile& tile = *tile_of_face[place.face];
            const camera::Intrinsics& k = tile.intrinsics;
            const glm::dvec2 focal(k.fx, k.fy);
            const glm::dvec2 centre(k.cx, k.cy);
            const glm::dvec2 at = focal * place.at + centre + glm::dvec2(tile.x, tile.y);
            plan.map[i] = glm::ivec2(glm::floor(at * one + 0.5));
            plan.footprint[i] = glm::vec4(glm::vec2(focal * place.right), glm::vec2(focal * place.down));
            if (plan.depth_factor.empty()) continue;
            // The texel that nearest takes, in the tile.
            const glm::ivec2 nearest = (plan.map[i] + (1 << (LensPlan::fraction_bits - 1))) >> LensPlan::fraction_bits;
            const glm::dvec3 ray((glm::dvec2(nearest.x - tile.x, nearest.y - tile.y) - centre) / focal, 1.0);
            plan.depth_factor[i] = static_cast<float>(glm::dot(tile.tile_from_optical * glm::dvec3(0, 0, 1), ray));
        }
    }
}

}  // namespace

Result<LensPlan> make_lens_plan(const camera::CameraModel& camera, const world::LensSampling& sampling,
                                const LensPlanLimits& limits) {
    if (camera.size().pixels() > max_lens_pixels) {
        return error(ErrorKind::unsupported, "size: pictures through a lens have at most " +
                                                 std::to_string(max_lens_pixels >> 20) + " million pixels; " +
                                                 camera.size().to_string() + " has more");
    }
    const std::vector<glm::dvec3> rays = rays_of(camera);
    Survey plane(camera, rays, false);
    Survey cube(camera, rays, true);
    const bool try_plane = sampling.method != world::LensMethod::cube && plane.measure();
    if (!try_plane && sampling.method == world::LensMethod::warp) {
        return error(ErrorKind::unsupported,
                     "lens.method: no single plane holds this picture, parts of it are 85 deg or more from the axis; "
                     "use auto or cube");
    }
    LensPlan plan;
    bool has_plan = false;
    if (try_plane) {
        plan = layout(plane, camera, limits);
        has_plan = fits(plan, limits);
    }
    const bool is_mild = has_plan && texels_of(plan) < mild_ratio * camera.size().pixels();
    if (sampling.method != world::LensMethod::warp && !is_mild && cube.measure()) {
        LensPlan faces = layout(cube, camera, limits);
        const bool is_smaller = plane_preference * static_cast<double>(texels_of(faces)) < texels_of(plan);
        if (!has_plan || is_smaller) {
            has_plan = fits(faces, limits);
            plan = std::move(faces);
        }
    }
    if (!has_plan) {
        return error(ErrorKind::resource_exhausted, "lens: this picture needs a source of " + plan.source.to_string() +
                                                        " texels and the device draws at most " +
                                                        std::to_string(limits.max_side) + " a side and " +
                                                        std::to_string(limits.max_texels >> 20) +
                                                        " million in all; use a smaller size or less antialiasing");
    }
    fill_map(plan, plan.method == world::LensMethod::cube ? cube : plane);
    return plan;
}

}  // namespace camrig::render
