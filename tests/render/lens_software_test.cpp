#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/render/software/lens_pieces.h"
#include "core/render/software/lens_vertices.h"
#include "core/render/software/software_drawer.h"
#include "tests/render/support/gallery.h"
#include "tests/render/support/targets.h"

// Pictures through a lens by camrig's rasteriser: where things are against CameraModel in double, no gaps, the same
// bytes however the work is done, and Mesa's resampled pictures.
namespace camrig {
namespace {

constexpr Lens barrel{LensModel::plumb_bob, {-0.32, 0.13, 0, 0, -0.025}};
constexpr Lens folding{LensModel::plumb_bob, {-0.45, 0.12, 0.001, -0.0007, 0}};
constexpr Lens pincushion{LensModel::plumb_bob, {0.25, 0.05, -0.001, 0.0008, 0.01}};
constexpr Lens rational{LensModel::rational_polynomial, {0.3, -0.1, 0.0005, 0.0003, 0.01, 0.6, -0.05, 0.02}};
constexpr Lens fisheye{LensModel::equidistant, {-0.01, 0.002, 0, 0}};
constexpr Lens folding_fisheye{LensModel::equidistant, {-0.12, -0.015, 0, 0}};

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
            {"rational", {.size = size, .focal_px = 80, .lens = rational}},
            {"off centre", {.size = size, .intrinsics = Intrinsics{90, 97, 20, 100}, .lens = barrel}},
            {"fisheye of 90 deg", {.size = size, .focal_px = 130, .lens = fisheye}},
            {"fisheye of 180 deg", {.size = size, .focal_px = 51, .lens = fisheye}},
            {"fisheye of 220 deg", {.size = size, .focal_px = 42, .lens = fisheye}},
            {"fisheye of 290 deg", {.size = size, .focal_px = 39, .lens = fisheye}},
            {"fisheye that folds", {.size = size, .focal_px = 60, .lens = folding_fisheye}},
            {"tiny focal length", {.size = size, .focal_px = 12, .lens = folding_fisheye}},
            {"huge focal length", {.size = size, .focal_px = 5e4, .lens = barrel}},
            {"huge fisheye", {.size = size, .focal_px = 5e4, .lens = fisheye}}};
}

std::unique_ptr<SoftwareDrawer> drawer(SoftwareDrawer::Options options = {}) {
    options.pool = std::make_shared<FramePool>();
    return std::make_unique<SoftwareDrawer>(options);
}

FrameRef drawn(SoftwareDrawer& by, const SnapshotRef& snapshot, const View& view) {
    by.begin_instant(snapshot);
    EXPECT_TRUE(by.can_draw(view));
    const View* const asked = &view;
    std::vector<FrameRef> frames;
    by.draw({&asked, 1}, 0, frames);
    return frames.at(0);
}

Picture drawn(const TestWorld& world, const TestCamera& camera) {
    return {drawn(*drawer(), world.snapshot(), camera.view())};
}

std::shared_ptr<const LensView> lens_of(const TestCamera& camera) {
    const View view = camera.view();
    return LensView::create(view.spec->size, view.spec->intrinsics, view.spec->lens).value();
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
        const CameraModel& model = lens->model();
        std::vector<glm::vec3> points;
        std::vector<std::uint32_t> which;
        for (std::uint32_t i = 0; i < count; ++i) {
            // Half of them in the picture, whatever it sees.
            const auto ray =
                model.ray({random(2, 2 * i) * camera.size.width, random(2, 2 * i + 1) * camera.size.height});
            points.push_back(glm::vec3(i % 2 == 0 && ray ? *ray * (0.1 + i) : anywhere(1, i)));
            which.push_back(i);
        }
        std::array<std::vector<ScreenVertex>, 2> made;
        std::array<std::vector<std::int32_t>, 2> outside;
        for (const bool wide : {false, has_wide_lanes()}) {
            made[wide].resize(count);
            outside[wide].resize(count);
            std::vector<glm::vec2> ideal(count);
            project_through(LensNumbers(*lens, transform_of(camera)), camera.size, glm::dmat4(1.0), points.data(),
                            which, wide, made[wide].data(), ideal.data(), outside[wide].data());
        }
        double most = 0.0;
        int seen = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const ScreenVertex& at = made[0][i];
            if (has_wide_lanes()) {
                ASSERT_EQ(outside[0][i], outside[1][i]) << name;
                ASSERT_TRUE(at.x == made[1][i].x && at.y == made[1][i].y && at.depth == made[1][i].depth) << name;
            }
            const glm::dvec3 p(points[i]);
            const double w = lens->is_wide() ? glm::length(p) : p.z;
            if (w < camera.near_m) {
                ASSERT_TRUE((outside[0][i] & outside_near) != 0 || !std::isfinite(w)) << name;
                continue;
            }
            const auto px = model.project(p);
            const bool shows = px && model.in_image(*px);
            if (shows) {
                ++seen;
                ASSERT_EQ(outside[0][i], 0) << name << ", " << p.x << " " << p.y << " " << p.z;
                most = std::max({most, std::abs(at.x / 256.0 - px->x), std::abs(at.y / 256.0 - px->y)});
                ASSERT_NEAR(at.inverse_z * w, 1.0, 1e-6);
            } else if ((outside[0][i] & (outside_near | outside_guard)) == 0) {
                // Not before what is seen: beside the picture, or where no pixel sees anything.
                const glm::dvec2 there(at.x / 256.0, at.y / 256.0);
                const glm::dvec2 pixel = glm::round(there);
                ASSERT_TRUE(!model.in_image(there) || !model.ray(pixel) || glm::distance(there, pixel) > 0.01)
                    << name << ", " << p.x << " " << p.y << " " << p.z << " at " << there.x << " " << there.y;
            }
        }
        EXPECT_LT(most, 0.5 / 256.0 + 1e-3) << name;
        EXPECT_GT(seen, 5000) << name;
    }
}

TEST(LensPieces, HaveEdgesThatAreStraightWithinTheirTolerance) {
    for (const auto& [name, camera] : cameras()) {
        const auto lens = lens_of(camera);
        const CameraModel& model = lens->model();
        LensPieces pieces;
        double worst = 0.0, worst_depth = 0.0, sum2 = 0.0, looks = 0.0;
        std::size_t count = 0;
        for (std::uint64_t n = 0; n < 120; ++n) {
            // Small ones and such as reach around the camera.
            std::array<glm::dvec3, 3> corners;
            const glm::dvec3 middle = anywhere(3, n);
            for (std::size_t c = 0; c < 3; ++c)
                corners[c] = n % 2 == 0 ? anywhere(4, 3 * n + c)
                                        : middle + 0.3 * glm::length(middle) * anywhere(5, 3 * n + c) /
                                                       glm::length(anywhere(5, 3 * n + c));
            pieces.begin_view(*lens, transform_of(camera));
            pieces.divide(corners);
            ASSERT_LT(pieces.pieces().size(), 200000u) << name;
            count += pieces.pieces().size();
            for (const auto& piece : pieces.pieces()) {
                for (std::size_t i = 0; i < 3; ++i) {
                    const auto &a = pieces.points()[piece[i]], &b = pieces.points()[piece[(i + 1) % 3]];
                    // At three quarters between, as the picture has it.
                    for (const double u : {0.25, 0.5, 0.75}) {
                        const double share = u * a.w / (u * a.w + (1.0 - u) * b.w);
                        const glm::dvec3 p = a.p + (b.p - a.p) * share;
                        const auto px = model.project(p);
                        if (!px || !model.in_image(*px)) continue;
                        const glm::dvec2 along = glm::normalize(b.px - a.px), off = *px - a.px;
                        const double sag = std::abs(along.x * off.y - along.y * off.x);
                        worst = std::max(worst, sag);
                        sum2 += sag * sag;
                        ++looks;
                        const double inverse = (1.0 - u) / a.w + u / b.w;
                        const double w = lens->is_wide() ? glm::length(p) : p.z;
                        worst_depth = std::max(worst_depth, std::abs(inverse * w - 1.0));
                    }
                }
            }
        }
        EXPECT_TRUE(count > 100u || camera.focal_px > 1e3) << name;
        EXPECT_LT(worst, 2.0 * LensView::max_sag_px) << name;
        EXPECT_LT(std::sqrt(sum2 / std::max(looks, 1.0)), 0.5 * LensView::max_sag_px) << name;
        EXPECT_LT(worst_depth, 1.25 * LensView::max_depth_share) << name;
    }
}

/// A place and four at some distance.
std::array<glm::dvec2, 5> around(double px) {
    return {glm::dvec2(0, 0), {px, 0}, {-px, 0}, {0, px}, {0, -px}};
}

/// A sphere around the camera of shaken triangles, small and large ones.
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
    Material material = colored(glm::vec3(1.0f), true);
    material.double_sided = true;
    if (is_blended) {
        material.alpha_mode = AlphaMode::blend;
        material.base_color.a = 0.5f;
    }
    TestWorld world;
    world.objects = {instance_of(model_of(triangles(result), material))};
    return world;
}

TEST(LensWatertight, WhatSurroundsTheCameraCoversEveryPixelOnce) {
    struct Shell {
        int rows, columns;
        double radius;
    };
    for (const auto& [name, camera] : cameras()) {
        const CameraModel model = camera.model();
        // From triangles of half a sky, kilometres away, to those of a pixel; and one just outside of the near plane.
        for (const Shell& of : {Shell{2, 3, 9e3}, Shell{5, 9, 0.2}, Shell{40, 70, 5.0}, Shell{160, 300, 5.0}}) {
            for (const bool is_blended : {false, true}) {
                const Picture picture = drawn(shell(of.rows, of.columns, of.radius, is_blended, 7), camera);
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
                EXPECT_EQ(wrong, 0) << name << ", " << of.rows << " rows" << (is_blended ? ", half clear" : "")
                                    << ": pixels of " << pixels;
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

TEST(LensPictures, ShowWhatRaysHitFirst) {
    const auto world_from_optical = [](glm::dvec3 p) { return glm::vec3(glm::dvec3(p.z, -p.x, -p.y)); };
    for (const auto& [name, camera] : cameras()) {
        const auto lens = lens_of(camera);
        const CameraModel& model = lens->model();
        // Large triangles through each other, around and behind the camera, each of another colour.
        std::vector<glm::dvec3> corners;
        TestWorld world;
        for (std::uint64_t n = 0; n < 60; ++n) {
            std::vector<glm::vec3> points;
            const glm::dvec3 middle = (1.0 + 0.1 * n) * glm::normalize(anywhere(8, n));
            for (std::uint64_t c = 0; c < 3; ++c) {
                const glm::dvec3 p = middle + (0.3 + 0.05 * n) * glm::normalize(anywhere(9, 3 * n + c));
                const glm::vec3 of_world = world_from_optical(p);
                points.push_back(of_world);
                corners.emplace_back(-of_world.y, -of_world.z, of_world.x);
            }
            Material material =
                colored(glm::vec3(random(10, 3 * n), random(10, 3 * n + 1), random(10, 3 * n + 2)), true);
            material.double_sided = true;
            world.objects.push_back(
                instance_of(model_of(triangles(points), material), {}, static_cast<std::uint32_t>(n + 1)));
        }
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
                // Where an edge or a crossing passes within a twentieth of a pixel, either side may show.
                bool is_found = false;
                for (const glm::dvec2& off : around(0.05)) {
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
        // Crossings of two surfaces move with their depths.
        EXPECT_LE(wrong, pixels / 1000) << name << " of " << pixels;
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
        const CameraModel model = camera.model();
        std::vector<Disc> discs;
        for (int y = 20; y < size.height - 19; y += 40)
            for (int x = 20; x < size.width - 19; x += 40)
                if (const auto disc = disc_at(model, {x + 0.3, y + 0.1}, 4.0, radius_px)) discs.push_back(*disc);
        const SnapshotRef world = world_of(discs).snapshot();
        std::vector<glm::dvec2> off(discs.size(), glm::dvec2(0.0));
        for (int phase = 0; phase < phases * phases; ++phase) {
            TestCamera moved = camera;
            const Intrinsics k = model.intrinsics();
            moved.intrinsics = {k.fx, k.fy, k.cx + double(phase % phases) / phases,
                                k.cy + double(phase / phases) / phases};
            const Picture picture{drawn(*by, world, moved.view())};
            const CameraModel moved_model = moved.model();
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
        const CameraModel model = camera.model();
        Primitive floor = rectangle({200, 0, -1.5}, {200, 0, 0}, {0, 200, 0});
        floor.colors.clear();
        for (const glm::vec3& p : floor.positions) floor.colors.emplace_back(glm::vec3(p.x / 400.0f), 1.0f);
        Material material = colored(glm::vec3(1.0f), true);
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
    std::vector<std::unique_ptr<SoftwareDrawer>> drawers;
    SoftwareDrawer::Options options;
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
        View view = film.view("lobby", camera.size, static_cast<std::uint32_t>(views.size() + 1));
        auto spec = std::make_shared<CameraSpec>(*view.spec);
        spec->lens = camera.lens;
        spec->intrinsics = camera.view().spec->intrinsics;
        view.spec = spec;
        views.push_back(view);
    }
    for (int n = 0; n < 3; ++n) {
        const SnapshotRef snapshot = film.at(3 * ns_per_s + n * 200 * ns_per_ms);
        for (const View& view : views) {
            const FrameRef first = drawn(*drawers[0], snapshot, view);
            for (std::size_t i = 1; i < drawers.size(); ++i)
                EXPECT_TRUE(std::ranges::equal(first->bytes(), drawn(*drawers[i], snapshot, view)->bytes()))
                    << to_string(view.spec->lens.model) << ", drawer " << i << ", instant " << n;
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
            const Primitive body = box(glm::vec3(0.2, 0.3, 0.9));
            Material white = colored(glm::vec3(1.0f), true);
            white.double_sided = true;
            world.objects = {instance_of(model_of(body, white), at)};
            const Picture picture = drawn(world, camera);
            glm::dmat4 optical_from_local(transform_of(camera).optical_from(glm::translate(glm::dmat4(1.0), at)));
            const Box bounds{glm::vec3(-0.2, -0.3, -0.9), glm::vec3(0.2, 0.3, 0.9)};
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

TEST(LensPictures, AreThoseThatMesaResamples) {
    auto mesas = create_renderer({.device = "llvmpipe", .pool = std::make_shared<FramePool>()}).value();
    Film film("hall");
    const SnapshotRef hall = film.at(3 * ns_per_s);
    const auto by = drawer();
    for (const auto& [name, camera] : cameras()) {
        if (camera.focal_px > 1e3 || camera.focal_px < 40) continue;
        View view = film.view("lobby", camera.size, 1);
        auto spec = std::make_shared<CameraSpec>(*view.spec);
        const View of_camera = camera.view();
        spec->lens = of_camera.spec->lens;
        spec->intrinsics = of_camera.spec->intrinsics;
        spec->antialias = Antialias::none;
        view.spec = spec;
        for (const Quality quality : {Quality::fast, Quality::simple}) {
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

TEST(LensPictures, OfAFisheyeThatSeesRightBehindItselfAreDrawnElsewhere) {
    const auto by = drawer();
    by->begin_instant(TestWorld{}.snapshot());
    EXPECT_FALSE(by->can_draw(TestCamera{.size = {160, 120}, .focal_px = 19, .lens = fisheye}.view()));
    EXPECT_TRUE(by->can_draw(TestCamera{.size = {160, 120}, .focal_px = 42, .lens = fisheye}.view()));
}

TEST(LensPictures, ATriangleOfKilometresAroundTheCameraIsBoundedWork) {
    for (const auto& [name, camera] : cameras()) {
        const auto lens = lens_of(camera);
        LensPieces pieces;
        pieces.begin_view(*lens, transform_of(camera));
        std::size_t count = 0;
        for (std::uint64_t n = 0; n < 40; ++n) {
            const double height = n % 2 == 0 ? 1.5 : 1e-4;
            pieces.divide({glm::dvec3(-3e6, height, -4e6 + n), {5e6, height, -1e6}, {-2e5, height, 6e6 - 1e5 * n}});
            count += pieces.pieces().size();
        }
        EXPECT_LE(count, std::size_t{LensPieces::max_pieces} + 1000) << name;
        EXPECT_LT(count, 40u * 100000u) << name;
    }
}

}  // namespace
}  // namespace camrig
