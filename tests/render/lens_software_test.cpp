#include <cmath>
#include <cstdio>
#include <numbers>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/render/software/lens_rays.h"
#include "core/render/software/rasterizer.h"
#include "core/render/software/ray_triangles.h"
#include "core/render/software/software_drawer.h"
#include "tests/render/support/gallery.h"
#include "tests/render/support/targets.h"

// Pictures through a lens by camrig's rasteriser: where things are against CameraModel in double, no gaps, the same
// bytes however the work is done, and Mesa's resampled pictures.
namespace camrig::render {
namespace {

constexpr camera::Lens barrel{camera::LensModel::plumb_bob, {-0.32, 0.13, 0, 0, -0.025}};
constexpr camera::Lens folding{camera::LensModel::plumb_bob, {-0.45, 0.12, 0.001, -0.0007, 0}};
constexpr camera::Lens pincushion{camera::LensModel::plumb_bob, {0.25, 0.05, -0.001, 0.0008, 0.01}};
constexpr camera::Lens rational{camera::LensModel::rational_polynomial,
                                {0.3, -0.1, 0.0005, 0.0003, 0.01, 0.6, -0.05, 0.02}};
constexpr camera::Lens fisheye{camera::LensModel::equidistant, {-0.01, 0.002, 0, 0}};
constexpr camera::Lens folding_fisheye{camera::LensModel::equidistant, {-0.12, -0.015, 0, 0}};

struct Named {
    std::string name;
    TestCamera camera;
};
/// From mild to those that see behind themselves, and focal lengths from tiny to huge.
std::vector<Named> cameras() {
    const ImageSize size{160, 120};
    return {{"barrel", {.size = size, .focal_px = 98, .lens = barrel}},
            {"folds in the picture", {.size = size, .focal_px = 70, .lens = folding}},
            {"pincushion", {.size = size, .focal_px = 110, .lens = pincushion}},
            {"rational, no whole groups of pixels", {.size = {157, 119}, .focal_px = 80, .lens = rational}},
            {"off centre", {.size = size, .intrinsics = camera::Intrinsics{90, 97, 20, 100}, .lens = barrel}},
            {"fisheye of 90 deg", {.size = size, .focal_px = 130, .lens = fisheye}},
            {"fisheye of 180 deg", {.size = size, .focal_px = 51, .lens = fisheye}},
            {"fisheye of 220 deg", {.size = size, .focal_px = 42, .lens = fisheye}},
            {"fisheye of 290 deg", {.size = size, .focal_px = 39, .lens = fisheye}},
            {"fisheye that sees right behind itself", {.size = size, .focal_px = 19, .lens = fisheye}},
            {"fisheye that folds", {.size = size, .focal_px = 60, .lens = folding_fisheye}},
            {"tiny focal length", {.size = size, .focal_px = 12, .lens = folding_fisheye}},
            {"huge focal length", {.size = size, .focal_px = 5e4, .lens = barrel}},
            {"huge fisheye", {.size = size, .focal_px = 5e4, .lens = fisheye}}};
}

std::unique_ptr<software::SoftwareDrawer> drawer(software::SoftwareDrawer::Options options = {}) {
    options.pool = std::make_shared<frame::FramePool>();
    return std::make_unique<software::SoftwareDrawer>(options);
}

/// All pictures that are wanted.
std::vector<frame::FrameRef> all_drawn(software::SoftwareDrawer& by, const world::SnapshotRef& snapshot,
                                       const View& view) {
    by.begin_instant(snapshot);
    EXPECT_TRUE(by.can_draw(view));
    const View* const asked = &view;
    std::vector<frame::FrameRef> frames;
    by.draw({&asked, 1}, 0, frames);
    return frames;
}

frame::FrameRef drawn(software::SoftwareDrawer& by, const world::SnapshotRef& snapshot, const View& view) {
    return all_drawn(by, snapshot, view).at(0);
}

Picture drawn(const TestWorld& world, const TestCamera& camera) {
    return {drawn(*drawer(), world.snapshot(), camera.view())};
}

std::shared_ptr<const scene::LensView> lens_of(const TestCamera& camera) {
    const View view = camera.view();
    return scene::LensView::create(view.spec->size, view.spec->intrinsics, view.spec->lens).value();
}

ViewTransform transform_of(const TestCamera& camera) {
    const View view = camera.view();
    return make_view_transform(view.pose, view.spec->size, view.spec->intrinsics, view.spec->near_m, view.spec->far_m);
}

double random(std::uint64_t stream, std::uint64_t i) {
    return random_unit(11, stream, i);
}

/// Any direction, distances from 0.02 to 2000 m.
glm::dvec3 anywhere(std::uint64_t stream, std::uint64_t i) {
    const double z = 2.0 * random(stream, 3 * i) - 1.0, turn = 2.0 * std::numbers::pi * random(stream, 3 * i + 1);
    const double across = std::sqrt(1.0 - z * z);
    return glm::dvec3(across * std::cos(turn), across * std::sin(turn), z) *
           (0.02 * std::pow(1e5, random(stream, 3 * i + 2)));
}

TEST(LensVertices, AreWhereTheCameraModelSeesThem) {
    constexpr int count = 20000;
    for (const auto& [name, camera] : cameras()) {
        const auto lens = lens_of(camera);
        const camera::CameraModel& model = lens->model();
        std::vector<glm::vec3> points;
        std::vector<std::uint32_t> which;
        for (std::uint32_t i = 0; i < count; ++i) {
            // Half of them in the picture, whatever it sees.
            const auto ray =
                model.ray({random(2, 2 * i) * camera.size.width, random(2, 2 * i + 1) * camera.size.height});
            points.push_back(glm::vec3(i % 2 == 0 && ray ? *ray * (0.1 + i) : anywhere(1, i)));
            which.push_back(i);
        }
        std::array<std::vector<software::LensVertex>, 2> made;
        for (const bool wide : {false, software::has_wide_lanes()}) {
            made[wide].resize(count);
            place_vertices(software::LensNumbers(*lens, transform_of(camera)), camera.size, glm::dmat4(1.0),
                           points.data(), which, wide, made[wide].data());
        }
        double most = 0.0;
        int seen = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const software::LensVertex &at = made[0][i], &same = made[1][i];
            if (software::has_wide_lanes()) {
                ASSERT_TRUE(at.outside == same.outside && at.x == same.x && at.y == same.y && at.at == same.at) << name;
            }
            ASSERT_TRUE(at.at == points[i]) << name;
            const glm::dvec3 p(points[i]);
            const double w = lens->is_wide() ? glm::length(p) : p.z;
            if (w < camera.near_m) {
                ASSERT_TRUE((at.outside & software::outside_near) != 0 || !std::isfinite(w)) << name;
                continue;
            }
            const auto px = model.project(p);
            if (px && model.in_image(*px)) {
                ++seen;
                ASSERT_EQ(at.outside, 0) << name << ", " << p.x << " " << p.y << " " << p.z;
                most = std::max({most, std::abs(at.x / 256.0 - px->x), std::abs(at.y / 256.0 - px->y)});
            } else if (at.outside == 0) {
                // Beside the picture, but so little that an edge from there may be bent into it.
                ASSERT_TRUE(px && std::abs(at.x / 256.0 - px->x) < 0.01 && std::abs(at.y / 256.0 - px->y) < 0.01)
                    << name;
            }
        }
        EXPECT_LT(most, 0.5 / 256.0 + 1e-3) << name;
        EXPECT_GT(seen, 5000) << name;
    }
}

TEST(RayTriangles, ShowAnEdgeThatIsBentIntoThePictureFromItsEndsBesideIt) {
    const TestCamera camera{
        .size = {1920, 1080}, .focal_px = 1000, .lens = {camera::LensModel::plumb_bob, {0.1, 0, 0, 0, 0}}};
    const camera::CameraModel model = camera.model();
    const auto at = [&](double x, double y) {
        const glm::dvec3 p = *model.ray({x, y}) * 4.0;
        return glm::vec3(p.z, -p.x, -p.y);
    };
    world::Material white = colored(glm::vec3(1.0f), true);
    white.double_sided = true;
    TestWorld world;
    world.objects = {instance_of(model_of(triangles({at(-0.502, 450), at(-0.502, 630), at(-20, 540)}), white))};
    EXPECT_EQ(drawn(world, camera).red(0, 540), 255);
}

TEST(LensRays, AreThoseOfTheCameraModelWithinTheBoundsOfTheirTiles) {
    for (const auto& [name, camera] : cameras()) {
        const auto lens = lens_of(camera);
        const software::LensRays rays(*lens, software::has_wide_lanes());
        const software::LensRays plain(*lens, false);
        const auto of = rays.rays(), same = plain.rays();
        int seen = 0;
        for (int y = 0; y < camera.size.height; ++y) {
            for (int x = 0; x < camera.size.width; ++x) {
                const glm::dvec3 ray(of.x(y)[x], of.y(y)[x], of.z(y)[x]);
                ASSERT_TRUE(ray == glm::dvec3(same.x(y)[x], same.y(y)[x], same.z(y)[x])) << name;
                ASSERT_TRUE(ray == ray && ray != glm::dvec3(0.0)) << name;
                for (const auto& [grid, side] : {std::pair(&rays.tiles(), 8), std::pair(&rays.blocks(), 64)}) {
                    const int i = x / side, j = y / side;
                    ASSERT_TRUE(grid->low_x.rows()(j)[i] <= ray.x && ray.x <= grid->high_x.rows()(j)[i]) << name;
                    ASSERT_TRUE(grid->low_y.rows()(j)[i] <= ray.y && ray.y <= grid->high_y.rows()(j)[i]) << name;
                    ASSERT_TRUE(grid->low_z.rows()(j)[i] <= ray.z && ray.z <= grid->high_z.rows()(j)[i]) << name;
                }
                const auto expected = lens->model().ray({x, y});
                if (!expected) continue;
                ++seen;
                const glm::dvec3 direction = lens->is_wide() ? *expected : *expected / expected->z;
                ASSERT_LT(glm::distance(ray, direction), 2e-7 * glm::length(direction)) << name << " " << x << "," << y;
            }
        }
        EXPECT_GT(seen, 400) << name;
    }
}

/// A place and four at some distance.
std::array<glm::dvec2, 5> around(double px) {
    return {glm::dvec2(0, 0), {px, 0}, {-px, 0}, {0, px}, {0, -px}};
}

/// A sphere around the camera of shaken triangles, small and large ones; each a surface of its own, so that all edges
/// are outlines.
TestWorld shell(int rows, int columns, double radius, bool is_blended, std::uint64_t stream) {
    std::vector<glm::vec3> corners, result;
    for (int i = 0; i <= rows; ++i) {
        for (int j = 0; j <= columns; ++j) {
            const auto n = static_cast<std::uint64_t>(i * (columns + 1) + j % columns);
            const bool is_pole = i == 0 || i == rows;
            const double a = std::numbers::pi * (i + (is_pole ? 0.0 : 0.3 * (random(stream, 2 * n) - 0.5))) / rows;
            const double b =
                2.0 * std::numbers::pi * (j % columns + 0.3 * (random(stream, 2 * n + 1) - 0.5)) / columns + 0.01;
            corners.emplace_back(radius *
                                 glm::dvec3(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)));
            if (is_pole) corners.back() = glm::vec3(0.0f, 0.0f, static_cast<float>(i == 0 ? radius : -radius));
        }
    }
    const auto at = [&](int i, int j) { return corners[static_cast<std::size_t>(i * (columns + 1) + j)]; };
    for (int i = 0; i < rows; ++i) {
        for (int j = 0; j < columns; ++j) {
            for (const glm::vec3& p : {at(i, j), at(i + 1, j), at(i + 1, j + 1)}) result.push_back(p);
            for (const glm::vec3& p : {at(i, j), at(i + 1, j + 1), at(i, j + 1)}) result.push_back(p);
        }
    }
    world::Material material = colored(glm::vec3(1.0f), true);
    material.double_sided = true;
    if (is_blended) {
        material.alpha_mode = world::AlphaMode::blend;
        material.base_color.a = 0.5f;
    }
    world::Primitive apart = triangles(result);
    for (std::size_t i = 0; i < result.size(); ++i)
        apart.colors.emplace_back(1.0f, 1.0f, 1.0f, is_blended ? 1.0f : static_cast<float>(i / 3 % 4096) / 4096.0f);
    TestWorld world;
    world.objects = {instance_of(model_of(apart, material))};
    return world;
}

TEST(LensWatertight, WhatSurroundsTheCameraCoversEveryPixelOnce) {
    struct Shell {
        int rows, columns;
        double radius;
    };
    for (const auto& [name, camera] : cameras()) {
        const camera::CameraModel model = camera.model();
        // From triangles of half a sky, kilometres away, to those of a pixel; and one just outside of the near plane.
        for (const Shell& of : {Shell{2, 3, 9e3}, Shell{5, 9, 0.2}, Shell{40, 70, 5.0}, Shell{160, 300, 5.0}}) {
            for (const char* how : {"opaque", "by areas", "half clear"}) {
                const bool is_blended = how == std::string("half clear");
                TestCamera by = camera;
                by.antialias = how == std::string("by areas") ? world::Antialias::coverage : world::Antialias::none;
                const Picture picture = drawn(shell(of.rows, of.columns, of.radius, is_blended, 7), by);
                int wrong = 0, pixels = 0;
                for (int y = 0; y < camera.size.height; ++y) {
                    for (int x = 0; x < camera.size.width; ++x) {
                        // Beside a fold either side may show.
                        if (!std::ranges::all_of(around(0.1), [&](const glm::dvec2& off) {
                                return model.ray(glm::dvec2(x, y) + off).has_value();
                            }))
                            continue;
                        ++pixels;
                        wrong += picture.red(x, y) != srgb_code(is_blended ? 0.5 : 1.0);
                    }
                }
                EXPECT_EQ(wrong, 0) << name << ", " << of.rows << " rows, " << how << ": pixels of " << pixels;
            }
        }
    }
}

/// What a ray hits first, of triangles: number and distance along a ray.
struct Hit {
    int triangle = -1;
    double distance = std::numeric_limits<double>::infinity();
    double edge = 0.0;  ///< how far inside, of the shares
};
Hit hit_of(const std::vector<glm::dvec3>& corners, const glm::dvec3& ray, double near_m) {
    Hit hit;
    for (std::size_t i = 0; i < corners.size(); i += 3) {
        // Moeller and Trumbore, 1997.
        const glm::dvec3 e1 = corners[i + 1] - corners[i], e2 = corners[i + 2] - corners[i];
        const glm::dvec3 p = glm::cross(ray, e2);
        const double det = glm::dot(e1, p);
        if (det == 0.0) continue;
        const double u = glm::dot(-corners[i], p) / det;
        const glm::dvec3 q = glm::cross(-corners[i], e1);
        const double v = glm::dot(ray, q) / det, t = glm::dot(e2, q) / det;
        if (u < 0.0 || v < 0.0 || u + v > 1.0 || t < near_m || t >= hit.distance) continue;
        hit = {static_cast<int>(i / 3), t, std::min({u, v, 1.0 - u - v})};
    }
    return hit;
}

struct TrianglesAround {
    TestWorld world;
    std::vector<glm::dvec3> corners;  ///< in the optical frame
};
/// Large triangles through each other, around and behind the camera, each an object of another colour.
TrianglesAround triangles_around() {
    TrianglesAround made;
    for (std::uint64_t n = 0; n < 60; ++n) {
        std::vector<glm::vec3> points;
        const glm::dvec3 middle = (1.0 + 0.1 * n) * glm::normalize(anywhere(8, n));
        for (std::uint64_t c = 0; c < 3; ++c) {
            const glm::dvec3 p = middle + (0.3 + 0.05 * n) * glm::normalize(anywhere(9, 3 * n + c));
            const glm::vec3 of_world(glm::dvec3(p.z, -p.x, -p.y));
            points.push_back(of_world);
            made.corners.emplace_back(-of_world.y, -of_world.z, of_world.x);
        }
        world::Material material =
            colored(glm::vec3(random(10, 3 * n), random(10, 3 * n + 1), random(10, 3 * n + 2)), true);
        material.double_sided = true;
        made.world.objects.push_back(
            instance_of(model_of(triangles(points), material), {}, static_cast<std::uint32_t>(n + 1)));
    }
    return made;
}

TEST(RayTriangles, HaveBoxesThatHoldAllTheirPixels) {
    constexpr double inside = 1e-3;  // of the shares of the corners
    for (const auto& [name, camera] : cameras()) {
        const auto lens = lens_of(camera);
        const software::LensRays rays(*lens, software::has_wide_lanes());
        const software::LensNumbers numbers(*lens, transform_of(camera));
        const camera::CameraModel& model = lens->model();
        std::vector<std::pair<PixelRect, glm::dvec3>> directions;
        for (int y = 0; y < camera.size.height; ++y)
            for (int x = 0; x < camera.size.width; ++x)
                if (const auto ray = model.ray({x, y})) directions.push_back({{x, y, x + 1, y + 1}, *ray});
        int boxes = 0;
        for (std::uint64_t n = 0; n < 150; ++n) {
            // From parts of a pixel to half a sky, where the camera looks and beside it.
            const auto ray =
                model.ray({random(20, 2 * n) * camera.size.width, random(20, 2 * n + 1) * camera.size.height});
            const glm::dvec3 middle = 3.0 * (n % 4 != 0 && ray ? *ray : glm::normalize(anywhere(21, n)));
            const double size = 0.003 * std::pow(1e3, random(22, n)) * std::min(1.0, 100.0 / camera.focal_px);
            std::vector<glm::vec3> points;
            std::vector<glm::dvec3> corners;
            for (std::uint64_t c = 0; c < 3; ++c) {
                points.emplace_back(middle + size * 3.0 * glm::normalize(anywhere(23, 3 * n + c)));
                corners.emplace_back(points.back());
            }
            const std::vector<std::uint32_t> which{0, 1, 2};
            std::vector<software::LensVertex> vertices(3);
            place_vertices(numbers, camera.size, glm::dmat4(1.0), points.data(), which,
                           n % 2 == 0 && software::has_wide_lanes(), vertices.data());
            std::vector<software::ScreenTriangle> made;
            std::vector<software::RayTriangle> of_rays;
            software::OutlineScratch scratch;
            assemble_rays({{{0}, {1}, {2}}}, vertices.data(), {.is_double_sided = true}, numbers, rays,
                          n % 2 == 0 && software::has_wide_lanes(), scratch, made, of_rays);
            ASSERT_EQ(made.size(), of_rays.size());
            boxes += made.size() == 1;
            for (const auto& [pixel, direction] : directions) {
                if (hit_of(corners, direction, camera.near_m).edge < inside) continue;
                ASSERT_EQ(made.size(), 1u) << name << " " << n << " at " << pixel.x0 << "," << pixel.y0;
                ASSERT_TRUE(made[0].x0 <= pixel.x0 && pixel.x1 <= made[0].x1 && made[0].y0 <= pixel.y0 &&
                            pixel.y1 <= made[0].y1)
                    << name << " " << n << " at " << pixel.x0 << "," << pixel.y0;
            }
        }
        EXPECT_GT(boxes, 40) << name;
    }
}

TEST(LensPictures, ShowWhatRaysHitFirst) {
    for (const auto& [name, camera] : cameras()) {
        const auto lens = lens_of(camera);
        const camera::CameraModel& model = lens->model();
        const auto [world, corners] = triangles_around();
        const Picture picture = drawn(world, camera);
        int wrong = 0, pixels = 0;
        for (int y = 0; y < camera.size.height; ++y) {
            for (int x = 0; x < camera.size.width; ++x) {
                const auto ray = model.ray({x, y});
                if (!ray) {
                    ASSERT_EQ(picture.at(x, y), (std::array{0, 0, 0, 255})) << name << " " << x << "," << y;
                    continue;
                }
                const auto color_along = [&](const glm::dvec3& direction) {
                    const double near_m = lens->is_wide() ? camera.near_m : camera.near_m / direction.z;
                    const int n = hit_of(corners, direction, near_m).triangle;
                    if (n < 0) return std::array{0, 0, 0, 255};
                    const auto at = [&](int c) {
                        return srgb_code(double{static_cast<float>(random(10, static_cast<std::uint64_t>(3 * n + c)))});
                    };
                    return std::array{at(0), at(1), at(2), 255};
                };
                // Where an edge or a crossing passes within a thousandth of a pixel, either side may show.
                bool is_found = false;
                for (const glm::dvec2& off : around(0.001)) {
                    const auto beside = model.ray(glm::dvec2(x, y) + off);
                    if (!beside) continue;
                    const auto expected = color_along(*beside), seen = picture.at(x, y);
                    bool is_same = true;
                    for (std::size_t c = 0; c < 3; ++c) is_same &= std::abs(expected[c] - seen[c]) <= 1;
                    is_found |= is_same;
                }
                ++pixels;
                wrong += !is_found;
            }
        }
        EXPECT_EQ(wrong, 0) << name << " of " << pixels;
    }
}

TEST(LensPictures, ByCoverageShowTheAreasThatManyRaysSee) {
    constexpr int side = 16;
    for (const auto& [name, camera] : cameras()) {
        if (camera.focal_px > 1e3) continue;
        const auto lens = lens_of(camera);
        const camera::CameraModel& model = lens->model();
        const auto [world, corners] = triangles_around();
        TestCamera by_areas = camera;
        by_areas.antialias = world::Antialias::coverage;
        const Picture picture = drawn(world, by_areas);
        double squares = 0.0, worst = 0.0;
        int pixels = 0, off = 0;
        for (int y = 0; y < camera.size.height; ++y) {
            for (int x = y * 7 % 11; x < camera.size.width; x += 11) {
                glm::dvec3 seen(0.0);
                // Beside a pixel that sees nothing one shows what its middle does.
                bool is_whole = true;
                for (const glm::dvec2& beside : around(1.0))
                    is_whole &= model.ray(glm::dvec2(x, y) + beside).has_value();
                if (!is_whole) continue;
                for (int n = 0; n < side * side; ++n) {
                    const auto ray = model.ray({x + (n % side + 0.5) / side - 0.5, y + (n / side + 0.5) / side - 0.5});
                    if (!ray) continue;
                    const double near_m = lens->is_wide() ? camera.near_m : camera.near_m / ray->z;
                    const int hit = hit_of(corners, *ray, near_m).triangle;
                    if (hit < 0) continue;
                    const auto first = static_cast<std::uint64_t>(3 * hit);
                    seen += glm::dvec3(random(10, first), random(10, first + 1), random(10, first + 2));
                }
                for (int c = 0; c < 3; ++c) {
                    const double error =
                        std::abs(linear_of(picture.at(x, y)[static_cast<std::size_t>(c)]) - seen[c] / (side * side));
                    squares += error * error;
                    worst = std::max(worst, error);
                    off += error > 0.06;
                }
                ++pixels;
            }
        }
        const double rms = std::sqrt(squares / std::max(1, 3 * pixels));
        std::printf("%s: %.4f rms, %.3f at most, %d of %d channels off by more than 0.06\n", name.c_str(), rms, worst,
                    off, 3 * pixels);
        EXPECT_GT(pixels, 30) << name;
        // Where a pixel spans 5 degrees, rays do not change evenly in it.
        EXPECT_LT(rms, camera.focal_px < 15.0 ? 0.015 : 0.006) << name;
        EXPECT_LT(worst, 0.15) << name;
        EXPECT_LE(off, 3) << name;
    }
}

TEST(LensPictures, ShowDiscsWithinAFewThousandthsOfAPixel) {
    // So that what one sample a pixel costs averages out: pictures moved by sixths of a pixel.
    constexpr int phases = 6;
    constexpr double radius_px = 9.0, reach_px = radius_px + 6.0;
    const ImageSize size{320, 240};
    const std::vector<Named> lenses{{"barrel", {.size = size, .focal_px = 210, .lens = barrel}},
                                    {"pincushion", {.size = size, .focal_px = 225, .lens = pincushion}},
                                    {"rational", {.size = size, .focal_px = 200, .lens = rational}},
                                    {"fisheye of 120 deg", {.size = size, .focal_px = 190, .lens = fisheye}},
                                    {"fisheye of 180 deg", {.size = size, .focal_px = 102, .lens = fisheye}}};
    const auto by = drawer();
    for (const auto& [name, camera] : lenses) {
        const camera::CameraModel model = camera.model();
        std::vector<Disc> discs;
        for (int y = 20; y < size.height - 19; y += 40)
            for (int x = 20; x < size.width - 19; x += 40)
                if (const auto disc = disc_at(model, {x + 0.3, y + 0.1}, 4.0, radius_px)) discs.push_back(*disc);
        const world::SnapshotRef world = world_of(discs).snapshot();
        std::vector<glm::dvec2> off(discs.size(), glm::dvec2(0.0));
        for (int phase = 0; phase < phases * phases; ++phase) {
            TestCamera moved = camera;
            const camera::Intrinsics k = model.intrinsics();
            moved.intrinsics = {k.fx, k.fy, k.cx + double(phase % phases) / phases,
                                k.cy + double(phase / phases) / phases};
            const Picture picture{drawn(*by, world, moved.view())};
            const camera::CameraModel moved_model = moved.model();
            for (std::size_t i = 0; i < discs.size(); ++i) {
                const glm::dvec2 exact = exact_centroid(moved_model, discs[i]);
                off[i] += (seen_centroid(picture, exact, reach_px) - exact) / double(phases * phases);
            }
        }
        double most = 0.0, sum2 = 0.0;
        for (const glm::dvec2& error : off) {
            most = std::max(most, glm::length(error));
            sum2 += glm::dot(error, error);
        }
        const double rms = std::sqrt(sum2 / static_cast<double>(off.size()));
        std::printf("%s: %.4f px rms, %.4f at most, %zu discs\n", name.c_str(), rms, most, off.size());
        EXPECT_LT(rms, 0.012) << name;
        EXPECT_LT(most, 0.03) << name;
    }
}

TEST(LensPictures, HaveTexturesWhereTheyBelongOnALongFloor) {
    // A gradient along 400 m of floor and its edges, from one's feet to the horizon.
    for (const auto& [name, camera] : cameras()) {
        if (camera.focal_px > 1e3) continue;
        const camera::CameraModel model = camera.model();
        world::Primitive floor = rectangle({200, 0, -1.5}, {200, 0, 0}, {0, 200, 0});
        floor.colors.clear();
        for (const glm::vec3& p : floor.positions) floor.colors.emplace_back(glm::vec3(p.x / 400.0f), 1.0f);
        world::Material material = colored(glm::vec3(1.0f), true);
        material.double_sided = true;
        TestWorld world;
        world.environment.background = glm::vec3(1.0f);
        world.objects = {instance_of(model_of(floor, material))};
        const Picture picture = drawn(world, camera);
        int seen = 0;
        for (int y = 0; y < camera.size.height; ++y) {
            for (int x = 0; x < camera.size.width; ++x) {
                const auto ray = model.ray({x, y});
                if (!ray || ray->y < 0.01 || ray->z < 0.0) continue;
                double low = 1e9, high = -1e9;
                bool is_whole = true;  // neither the floor's end nor a fold is beside it
                for (const glm::dvec2& off : around(0.2)) {
                    const auto beside = model.ray(glm::dvec2(x, y) + off);
                    is_whole &= beside && beside->z > 0.0;
                    if (!beside) continue;
                    const double along = std::clamp(beside->z * 1.5 / beside->y / 400.0, 0.0, 1.0);
                    low = std::min(low, along);
                    high = std::max(high, along);
                }
                if (!is_whole || std::abs(ray->x * 1.5 / ray->y) > 190.0 || high > 0.99) continue;
                ++seen;
                ASSERT_GE(picture.red(x, y), srgb_code(low) - 1) << name << " " << x << "," << y;
                ASSERT_LE(picture.red(x, y), srgb_code(high) + 1) << name << " " << x << "," << y;
            }
        }
        EXPECT_GT(seen, 50) << name;
    }
}

TEST(LensSameBytes, WithAndWithoutWideLanesWithLayersAndByAnyNumberOfThreads) {
    std::vector<std::unique_ptr<software::SoftwareDrawer>> drawers;
    software::SoftwareDrawer::Options options;
    options.max_detail_error_px = 0.25;
    drawers.push_back(drawer(options));
    options.static_layer_bytes = std::int64_t{64} << 20;
    options.threads = 3;
    drawers.push_back(drawer(options));
    options.wide_lanes = false;
    drawers.push_back(drawer(options));
    Film film("hall");
    std::vector<View> views;
    for (const auto& [name, camera] : cameras()) {
        if (camera.focal_px > 1e3) continue;
        for (const world::Antialias antialias : {world::Antialias::none, world::Antialias::coverage}) {
            View view = film.view("lobby", camera.size, static_cast<std::uint32_t>(views.size() + 1));
            auto spec = std::make_shared<world::CameraSpec>(*view.spec);
            spec->lens = camera.lens;
            spec->intrinsics = camera.view().spec->intrinsics;
            spec->antialias = antialias;
            view.spec = spec;
            std::fill_n(view.kinds, frame::scene_kind_count, true);
            views.push_back(view);
        }
    }
    for (int n = 0; n < 3; ++n) {
        const world::SnapshotRef snapshot = film.at(3 * ns_per_s + n * 200 * ns_per_ms);
        for (const View& view : views) {
            const std::vector<frame::FrameRef> first = all_drawn(*drawers[0], snapshot, view);
            ASSERT_EQ(first.size(), std::size_t{frame::scene_kind_count});
            for (std::size_t i = 1; i < drawers.size(); ++i) {
                const std::vector<frame::FrameRef> other = all_drawn(*drawers[i], snapshot, view);
                ASSERT_EQ(other.size(), first.size());
                for (std::size_t k = 0; k < first.size(); ++k)
                    EXPECT_TRUE(std::ranges::equal(first[k]->bytes(), other[k]->bytes()))
                        << to_string(view.spec->lens.model) << ", kind " << k << ", drawer " << i << ", instant " << n;
            }
        }
    }
    EXPECT_GT(drawers[1]->counters().views_in_parts, views.size() - 1);
}

TEST(LensBounds, OfAMoverHoldAllItsPixels) {
    const TestWorld empty;
    for (const auto& [name, camera] : cameras()) {
        if (camera.focal_px > 1e3) continue;
        const auto lens = lens_of(camera);
        int held = 0;
        for (std::uint64_t n = 0; n < 60; ++n) {
            TestWorld world;
            const glm::dvec3 at = glm::normalize(anywhere(12, n)) * (0.3 + 6.0 * random(13, n));
            const world::Primitive body = box(glm::vec3(0.2, 0.3, 0.9));
            world::Material white = colored(glm::vec3(1.0f), true);
            white.double_sided = true;
            world.objects = {instance_of(model_of(body, white), at)};
            const Picture picture = drawn(world, camera);
            glm::dmat4 optical_from_local(transform_of(camera).optical_from(glm::translate(glm::dmat4(1.0), at)));
            const world::Box bounds{glm::vec3(-0.2, -0.3, -0.9), glm::vec3(0.2, 0.3, 0.9)};
            const auto rect = lens->pixels_of(optical_from_local, bounds, camera.near_m);
            const bool is_culled = lens->is_wide() ? !lens->may_see(optical_from_local, bounds, 0.0)
                                                   : !may_be_visible(lens->frustum(camera.near_m, 0.0),
                                                                     optical_from_local, bounds.min, bounds.max);
            for (int y = 0; y < camera.size.height; ++y) {
                for (int x = 0; x < camera.size.width; ++x) {
                    if (picture.red(x, y) == 0) continue;
                    ++held;
                    ASSERT_FALSE(is_culled) << name << " " << n;
                    ASSERT_TRUE(rect && x >= rect->x0 && x < rect->x1 && y >= rect->y0 && y < rect->y1)
                        << name << " " << n << " at " << x << "," << y;
                }
            }
        }
        EXPECT_GT(held, 500) << name;
    }
}

/// White points, or lines between every two of them, before black; positions in the optical frame.
TestWorld white_strokes(world::Topology topology, const TestCamera& camera, const std::vector<glm::dvec3>& positions) {
    world::Primitive primitive;
    primitive.topology = topology;
    const ViewTransform transform = transform_of(camera);
    for (std::uint32_t i = 0; const glm::dvec3& p : positions) {
        primitive.positions.push_back(glm::vec3(transform.eye + glm::transpose(transform.optical_from_world) * p));
        primitive.indices.push_back(i++);
    }
    primitive.bounds = {primitive.positions.front(), primitive.positions.front()};
    for (const glm::vec3& p : primitive.positions)
        primitive.bounds = {glm::min(primitive.bounds.min, p), glm::max(primitive.bounds.max, p)};
    TestWorld world;
    world.environment.background = glm::vec3(0.0f);
    world.objects = {instance_of(model_of(primitive, colored(glm::vec3(1.0f), true)))};
    return world;
}

/// Whether one of the pixels around sees nothing.
bool is_near_rim(const camera::CameraModel& model, const glm::dvec2& pixel) {
    for (const double down : {-2.0, 0.0, 2.0})
        for (const double right : {-2.0, 0.0, 2.0})
            if (!model.ray(glm::round(pixel) + glm::dvec2(right, down))) return true;
    return false;
}

TEST(LensStrokes, APointIsThePixelThatItLiesIn) {
    for (const auto& [name, camera] : cameras()) {
        const camera::CameraModel model = lens_of(camera)->model();
        std::vector<glm::dvec3> positions;
        std::vector<std::uint8_t> expected(static_cast<std::size_t>(camera.size.pixels())), unsure = expected;
        for (std::uint64_t i = 0; i < 400; ++i) {
            const glm::dvec2 pixel{random(21, 2 * i) * camera.size.width - 0.5,
                                   random(21, 2 * i + 1) * camera.size.height - 0.5};
            const auto ray = model.ray(pixel);
            if (!ray || is_near_rim(model, pixel)) continue;
            positions.push_back(*ray * (2.0 + static_cast<double>(i)));
            for (int y = 0; y < camera.size.height; ++y) {
                for (int x = 0; x < camera.size.width; ++x) {
                    const double out = std::max(std::abs(x - pixel.x), std::abs(y - pixel.y)) - 0.5;
                    const std::size_t at = static_cast<std::size_t>(y * camera.size.width + x);
                    if (std::abs(out) < 0.01)
                        unsure[at] = 1;
                    else if (out < 0.0)
                        expected[at] = 255;
                }
            }
        }
        if (positions.empty()) continue;  // what a tiny focal length sees is all rim
        const Picture picture = drawn(white_strokes(world::Topology::points, camera, positions), camera);
        int wrong = 0;
        for (int y = 0; y < camera.size.height; ++y)
            for (int x = 0; x < camera.size.width; ++x) {
                const std::size_t at = static_cast<std::size_t>(y * camera.size.width + x);
                if (!unsure[at]) wrong += (picture.red(x, y) == 255) != (expected[at] == 255);
            }
        EXPECT_EQ(wrong, 0) << name;
    }
}

TEST(LensStrokes, ALineGoesWhereTheLensShowsItWithoutAGap) {
    for (const auto& [name, camera] : cameras()) {
        const camera::CameraModel model = lens_of(camera)->model();
        for (std::uint64_t line = 0; line < 12; ++line) {
            const auto end = [&](std::uint64_t i) {
                return model.ray(
                    {random(22, 4 * line + i) * camera.size.width, random(22, 4 * line + i + 1) * camera.size.height});
            };
            const auto a = end(0), b = end(2);
            if (!a || !b) continue;
            const glm::dvec3 from = *a * 3.0, to = *b * 8.0;
            const Picture picture = drawn(white_strokes(world::Topology::lines, camera, {from, to}), camera);
            std::vector<double> nearest(static_cast<std::size_t>(camera.size.pixels()), 1e9);
            int gaps = 0;
            constexpr int steps = 4000;
            const auto start = model.project(from), stop = model.project(to);
            for (int i = 0; i <= steps; ++i) {
                const auto pixel = model.project(from + (to - from) * (static_cast<double>(i) / steps));
                if (!pixel) continue;
                bool is_drawn = false;
                const int px = static_cast<int>(std::lround(pixel->x)), py = static_cast<int>(std::lround(pixel->y));
                for (int y = py - 1; y <= py + 1; ++y) {
                    for (int x = px - 1; x <= px + 1; ++x) {
                        if (x < 0 || y < 0 || x >= camera.size.width || y >= camera.size.height) continue;
                        const double distance = std::hypot(x - pixel->x, y - pixel->y);
                        double& least = nearest[static_cast<std::size_t>(y * camera.size.width + x)];
                        least = std::min(least, distance);
                        is_drawn |= picture.red(x, y) == 255 && distance < 1.1;
                    }
                }
                const bool is_end = glm::distance(*pixel, *start) < 1.0 || glm::distance(*pixel, *stop) < 1.0;
                const bool is_inside = !is_end && !is_near_rim(model, *pixel) && pixel->x > 0.5 && pixel->y > 0.5 &&
                                       pixel->x < camera.size.width - 1.5 && pixel->y < camera.size.height - 1.5;
                gaps += is_inside && !is_drawn;
            }
            EXPECT_EQ(gaps, 0) << name << " " << line;
            int beside = 0;
            for (int y = 0; y < camera.size.height; ++y)
                for (int x = 0; x < camera.size.width; ++x)
                    beside +=
                        picture.red(x, y) == 255 && nearest[static_cast<std::size_t>(y * camera.size.width + x)] > 0.75;
            EXPECT_EQ(beside, 0) << name << " " << line;
        }
    }
}

TEST(LensPictures, AreThoseThatMesaResamples) {
    auto mesas = create_renderer({.device = "llvmpipe", .pool = std::make_shared<frame::FramePool>()}).value();
    Film film("hall");
    const world::SnapshotRef hall = film.at(3 * ns_per_s);
    const auto by = drawer();
    for (const auto& [name, camera] : cameras()) {
        if (camera.focal_px > 1e3 || camera.focal_px < 40) continue;
        View view = film.view("lobby", camera.size, 1);
        auto spec = std::make_shared<world::CameraSpec>(*view.spec);
        const View of_camera = camera.view();
        spec->lens = of_camera.spec->lens;
        spec->intrinsics = of_camera.spec->intrinsics;
        spec->antialias = world::Antialias::none;
        view.spec = spec;
        for (const world::Quality quality : {world::Quality::fast, world::Quality::simple}) {
            view.quality = quality;
            const Picture ours{drawn(*by, hall, view)};
            auto finished = mesas->draw(hall, 0, {&view, 1});
            ASSERT_TRUE(finished && finished->set.frames.size() == 1) << name;
            const Picture theirs{finished->set.frames[0]};
            // Theirs mixes four texels of its source: a pixel is within the colours around it.
            int wrong = 0;
            double sum = 0.0;
            for (int y = 1; y + 1 < camera.size.height; ++y) {
                for (int x = 1; x + 1 < camera.size.width; ++x) {
                    bool is_found = true;
                    for (std::size_t c = 0; c < 3; ++c) {
                        int low = 255, high = 0;
                        for (int v = y - 1; v <= y + 1; ++v) {
                            for (int u = x - 1; u <= x + 1; ++u) {
                                low = std::min(low, theirs.at(u, v)[c]);
                                high = std::max(high, theirs.at(u, v)[c]);
                            }
                        }
                        is_found &= ours.at(x, y)[c] >= low - 12 && ours.at(x, y)[c] <= high + 12;
                        sum += ours.at(x, y)[c] - theirs.at(x, y)[c];
                    }
                    wrong += !is_found;
                }
            }
            const double pixels = static_cast<double>(camera.size.pixels());
            EXPECT_LT(wrong / pixels, 0.06) << name << " " << to_string(quality);
            EXPECT_LT(std::abs(sum / pixels / 3.0), 1.5) << name << " " << to_string(quality);
        }
    }
}

TEST(LensWatertight, EdgesOnTheRaysOfPixelsBelongToOneOfThem) {
    // Four squares that meet on the axis, and everywhere along rows and columns of pixels.
    for (const camera::Lens& lens : {barrel, rational, fisheye}) {
        TestWorld world;
        for (const glm::vec3& side : {glm::vec3(0, 3, 3), {0, 3, -3}, {0, -3, 3}, {0, -3, -3}}) {
            world::Material material = colored(glm::vec3(1.0f), true);
            material.double_sided = true;
            material.alpha_mode = world::AlphaMode::blend;
            material.base_color.a = 0.5f;
            world.objects.push_back(
                instance_of(model_of(rectangle(glm::vec3(2, 0, 0) + side, {0, side.y, 0}, {0, 0, side.z}), material)));
        }
        camera::Lens straight = lens;
        if (lens.model == camera::LensModel::rational_polynomial)
            straight.coefficients[2] = straight.coefficients[3] = 0.0;
        const TestCamera camera{.size = {160, 120}, .intrinsics = camera::Intrinsics{80, 80, 80, 60}, .lens = straight};
        const camera::CameraModel model = camera.model();
        const Picture picture = drawn(world, camera);
        for (int y = 0; y < camera.size.height; ++y) {
            for (int x = 0; x < camera.size.width; ++x) {
                if (!model.ray({x, y})) continue;
                ASSERT_EQ(picture.red(x, y), srgb_code(0.5)) << to_string(lens.model) << " " << x << "," << y;
            }
        }
    }
}

TEST(LensTruth, IsWhatRaysHitFirst) {
    int all_seen = 0;
    for (const auto& [name, camera] : cameras()) {
        const auto lens = lens_of(camera);
        const camera::CameraModel& model = lens->model();
        const auto [world, corners] = triangles_around();
        View view = camera.view();
        std::ranges::fill(view.kinds, false);
        for (const frame::FrameKind kind : {frame::FrameKind::depth, frame::FrameKind::instance})
            view.kinds[index_of(kind)] = true;
        const std::vector<frame::FrameRef> frames = all_drawn(*drawer(), world.snapshot(), view);
        ASSERT_EQ(frames.size(), 2u);
        const auto* const depths = reinterpret_cast<const float*>(frames[0]->bytes().data());
        const auto* const ids = reinterpret_cast<const std::uint32_t*>(frames[1]->bytes().data());
        int seen = 0, edges = 0;
        for (int y = 0; y < camera.size.height; ++y) {
            for (int x = 0; x < camera.size.width; ++x) {
                const float depth = depths[y * camera.size.width + x];
                const std::uint32_t id = ids[y * camera.size.width + x];
                const auto ray = model.ray({x, y});
                const auto near_m = [&](const glm::dvec3& direction) {
                    return lens->is_wide() ? camera.near_m : camera.near_m / direction.z;
                };
                const Hit hit = ray ? hit_of(corners, *ray, near_m(*ray)) : Hit{};
                const bool is_certain = !ray || std::ranges::all_of(around(0.001), [&](const glm::dvec2& off) {
                    const auto beside = model.ray(glm::dvec2(x, y) + off);
                    return beside && hit_of(corners, *beside, near_m(*beside)).triangle == hit.triangle;
                });
                if (!is_certain) {
                    ++edges;
                    continue;
                }
                ASSERT_EQ(id, static_cast<std::uint32_t>(hit.triangle + 1)) << name << " " << x << "," << y;
                if (hit.triangle < 0) {
                    ASSERT_TRUE(std::isinf(depth)) << name << " " << x << "," << y;
                    continue;
                }
                ++seen;
                // What the rounding of a ray moves it.
                double tolerance = 1e-6 * hit.distance;
                for (const glm::dvec2& off : around(1e-4)) {
                    const auto beside = model.ray(glm::dvec2(x, y) + off);
                    tolerance = std::max(tolerance, std::abs(hit_of(corners, *beside, 0.0).distance - hit.distance));
                }
                ASSERT_NEAR(depth, hit.distance * ray->z, tolerance) << name << " " << x << "," << y;
            }
        }
        EXPECT_LE(edges, 2 + seen / 100) << name;
        all_seen += seen;
    }
    EXPECT_GT(all_seen, 40000);
}

}  // namespace
}  // namespace camrig::render
