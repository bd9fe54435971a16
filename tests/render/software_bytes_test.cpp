#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <string_view>
#include <thread>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/render/software/software_drawer.h"
#include "core/render/view_frames.h"
#include "tests/render/support/claims.h"
#include "tests/render/support/gallery.h"

// camrig's rasteriser for itself: no gaps, nothing twice, the same bytes however the work is done.
namespace camrig::render {
namespace {

std::unique_ptr<software::SoftwareDrawer> drawer(software::SoftwareDrawer::Options options = {}) {
    options.pool = std::make_shared<frame::FramePool>();
    return std::make_unique<software::SoftwareDrawer>(options);
}

software::SoftwareDrawer::Options with_layers(std::int64_t bytes = std::int64_t{64} << 20) {
    software::SoftwareDrawer::Options options;
    options.static_layer_bytes = bytes;
    return options;
}

std::vector<frame::FrameRef> drawn(software::SoftwareDrawer& by, const world::SnapshotRef& snapshot,
                                   const std::vector<View>& views) {
    by.begin_instant(snapshot);
    std::vector<const View*> asked;
    for (const View& view : views) {
        EXPECT_TRUE(by.can_draw(view));
        asked.push_back(&view);
    }
    std::vector<frame::FrameRef> frames;
    by.draw(asked, 0, frames);
    return frames;
}

Picture drawn(const TestWorld& world, const TestCamera& camera) {
    const auto by = drawer();
    return {drawn(*by, world.snapshot(), {camera.view()}).at(0)};
}

bool are_equal(const frame::FrameRef& a, const frame::FrameRef& b) {
    return std::ranges::equal(a->bytes(), b->bytes());
}

View numbered(View view, std::uint32_t camera) {
    view.camera = CameraId{camera};
    return view;
}

View with(View view, world::Antialias antialias) {
    auto spec = std::make_shared<world::CameraSpec>(*view.spec);
    spec->antialias = antialias;
    view.spec = spec;
    return view;
}

double random(std::uint64_t stream, std::uint64_t i) {
    return random_unit(4, stream, i);
}

/// 2 m in front of the test camera; at 128 px focal length a metre is 64 pixels.
constexpr double wall_m = 2.0, focal_px = 128.0, px_m = wall_m / focal_px;

/// A grid over more than the picture whose corners are moved, those of large cells some onto middles and corners of
/// pixels, but never so far that it folds over: by less than a third of a cell.
std::vector<glm::vec3> shaken_grid(int columns, int rows, double width_px, double height_px, std::uint64_t stream) {
    std::vector<glm::dvec2> corners;
    for (int i = 0; i <= rows; ++i) {
        for (int j = 0; j <= columns; ++j) {
            const auto n = static_cast<std::uint64_t>(i * (columns + 1) + j);
            glm::dvec2 at((j - 0.5 * columns + 0.25 * random(stream, 3 * n)) * width_px,
                          (i - 0.5 * rows + 0.25 * random(stream, 3 * n + 1)) * height_px);
            const bool is_rounded = random(stream, 3 * n + 2) < 0.3;
            if (is_rounded && width_px >= 8.0) at.x = std::round(2.0 * at.x) / 2.0;
            if (is_rounded && height_px >= 8.0) at.y = std::round(2.0 * at.y) / 2.0;
            corners.push_back(at);
        }
    }
    std::vector<glm::vec3> result;
    const auto add = [&](int i, int j) {
        const glm::dvec2 at = corners[static_cast<std::size_t>(i * (columns + 1) + j)] * px_m;
        result.emplace_back(wall_m, -at.x, -at.y);
    };
    for (int i = 0; i < rows; ++i) {
        for (int j = 0; j < columns; ++j) {
            add(i, j), add(i + 1, j), add(i + 1, j + 1);
            add(i, j), add(i + 1, j + 1), add(i, j + 1);
        }
    }
    return result;
}

/// Slivers from one point to a ring around the picture.
std::vector<glm::vec3> fan(int count, glm::dvec2 middle_px) {
    std::vector<glm::vec3> result;
    const auto rim = [&](int i) {
        const double angle = 2.0 * std::numbers::pi * i / count;
        return glm::vec3(glm::dvec3(wall_m, 300.0 * px_m * std::cos(angle), 300.0 * px_m * std::sin(angle)));
    };
    for (int i = 0; i < count; ++i) {
        result.emplace_back(wall_m, -middle_px.x * px_m, -middle_px.y * px_m);
        result.push_back(rim(i));
        result.push_back(rim((i + 1) % count));
    }
    return result;
}

/// Covers every pixel from `first_row` on, once: opaque it leaves no background, half clear it is blended once.
void expect_watertight(const std::vector<glm::vec3>& corners, ImageSize size, int first_row, const std::string& what) {
    // Each triangle a surface of its own: all edges are outlines, and every pixel is one of areas.
    world::Primitive apart = triangles(corners);
    for (std::size_t i = 0; i < corners.size(); ++i)
        apart.colors.emplace_back(1.0f, 1.0f, 1.0f, static_cast<float>(i / 3 % 4096) / 4096.0f);
    world::Material white = colored(glm::vec3(1.0f), true);
    white.double_sided = true;
    TestWorld areas;
    areas.objects = {instance_of(model_of(apart, white))};
    const Picture covered = drawn(areas, {.size = size, .focal_px = focal_px, .antialias = world::Antialias::coverage});
    int open = 0;
    for (int y = first_row; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) open += covered.red(x, y) != 255;
    }
    EXPECT_EQ(open, 0) << what << ", by areas: pixels of " << size.width * (size.height - first_row);
    for (const auto& [is_blended, antialias] : {std::pair{false, world::Antialias::none},
                                                {true, world::Antialias::none},
                                                {true, world::Antialias::coverage}}) {
        world::Material material = colored(glm::vec3(1.0f), true);
        material.double_sided = true;
        if (is_blended) {
            material.alpha_mode = world::AlphaMode::blend;
            material.base_color.a = 0.5f;
        }
        TestWorld world;
        world.objects = {instance_of(model_of(triangles(corners), material))};
        const Picture picture = drawn(world, {.size = size, .focal_px = focal_px, .antialias = antialias});
        int wrong = 0;
        for (int y = first_row; y < size.height; ++y) {
            for (int x = 0; x < size.width; ++x) wrong += picture.red(x, y) != srgb_code(is_blended ? 0.5 : 1.0);
        }
        EXPECT_EQ(wrong, 0) << what << (is_blended ? ", half clear" : ", opaque") << ": pixels of "
                            << size.width * (size.height - first_row);
    }
}

TEST(Watertight, WhatSharesEdgesLeavesNoGapAndDrawsNoPixelTwice) {
    // Even sizes put the middles of pixels at halves of the grid's numbers, odd ones at wholes.
    for (const ImageSize size : {ImageSize{128, 96}, ImageSize{127, 95}}) {
        for (std::uint64_t stream = 1; stream <= 4; ++stream) {
            const std::string which = size.to_string() + ", shaken " + std::to_string(stream);
            expect_watertight(shaken_grid(24, 18, 10.0, 10.0, stream), size, 0, "large " + which);
            expect_watertight(shaken_grid(160, 120, 1.3, 1.3, stream), size, 0, "of a pixel " + which);
            expect_watertight(shaken_grid(800, 6, 0.25, 40.0, stream), size, 0, "slivers up " + which);
            expect_watertight(shaken_grid(6, 800, 40.0, 0.25, stream), size, 0, "slivers across " + which);
            for (const double side : {4e3, 4e4, 4e6, 4e9})
                expect_watertight(shaken_grid(2, 2, side, 0.7 * side, stream), size, 0, "huge " + which);
        }
        expect_watertight(fan(2000, {0.0, 0.0}), size, 0, "fan " + size.to_string());
        expect_watertight(fan(2000, {17.3, -20.9}), size, 0, "fan aside " + size.to_string());
    }
}

TEST(Watertight, WhatIsClippedToo) {
    // A floor through and behind the camera, far past all sides of the picture.
    std::vector<glm::vec3> floor;
    for (const glm::vec3& at : shaken_grid(12, 12, 1.0, 1.0, 9))
        floor.emplace_back(at.z / px_m * 900.0, at.y / px_m * 900.0, -0.9);
    expect_watertight(floor, {128, 96}, 60, "floor");
    std::vector<glm::vec3> slivers;
    for (const glm::vec3& at : fan(500, {3.0, 2.0})) slivers.emplace_back(at.z * 100.0f, at.y * 100.0f, -0.9f);
    expect_watertight(slivers, {128, 96}, 60, "slivers of a floor");
}

/// How far along the direction a triangle is hit; 0: not.
double distance_along(glm::dvec3 direction, const glm::vec3* corners) {
    const glm::dvec3 a(corners[0]), ab = glm::dvec3(corners[1]) - a, ac = glm::dvec3(corners[2]) - a;
    const glm::dvec3 p = glm::cross(direction, ac);
    const double inverse = 1.0 / glm::dot(ab, p), u = -glm::dot(a, p) * inverse;
    const glm::dvec3 q = glm::cross(-a, ab);
    const double v = glm::dot(direction, q) * inverse, along = glm::dot(ac, q) * inverse;
    return u >= 0.0 && v >= 0.0 && u + v <= 1.0 ? along : 0.0;
}

/// One of side * side rays spread over a pixel of the test camera.
glm::dvec3 ray_in_pixel(ImageSize size, double focal, int x, int y, int ray, int side) {
    const double u = x + (ray % side + 0.5) / side - 0.5, v = y + (ray / side + 0.5) / side - 0.5;
    return {1.0, -(u - 0.5 * (size.width - 1)) / focal, -(v - 0.5 * (size.height - 1)) / focal};
}

TEST(Areas, OfTrianglesOfAnyKindAreThoseThatManyRaysSee) {
    // Some cross the eye's plane, are slivers, cut each other or are seen from their edges.
    constexpr ImageSize size{40, 30};
    constexpr double focal = 30.0, near_m = 0.05;
    constexpr int side = 16;
    double squares = 0.0, worst = 0.0;
    int count = 0, off = 0;
    for (std::uint64_t round = 0; round < 12; ++round) {
        std::vector<glm::vec3> corners;
        std::uint64_t drawn_numbers = 0;
        const auto at = [&](double low, double high) {
            return low + (high - low) * random(40 + round, drawn_numbers++);
        };
        for (int i = 0; i < 14; ++i) {
            const auto within = [&](double x0, double x1, double y, double z) {
                const double up = at(-z, z), aside = at(-y, y);  // in this order with every compiler
                return glm::vec3(at(x0, x1), aside, up);
            };
            const glm::vec3 first = within(-1.0, 9.0, 4.0, 3.0);
            const double reach = i % 3 == 0 ? 0.1 : 3.0;
            for (int k = 0; k < 3; ++k) corners.push_back(first + within(-3.0, 3.0, reach, 3.0));
        }
        const double origin = round % 2 == 0 ? 0.0 : 1e6;
        TestWorld world;
        for (std::size_t i = 0; i < corners.size(); i += 3) {
            world::Material material = colored(glm::vec3(static_cast<float>(i / 3 + 1) / 16.0f, 0.0f, 0.0f), true);
            material.double_sided = true;
            world.objects.push_back(instance_of(
                model_of(triangles({corners[i], corners[i + 1], corners[i + 2]}), material), glm::dvec3(origin)));
        }
        const Picture picture = drawn(
            world,
            {.eye = glm::dvec3(origin), .size = size, .focal_px = focal, .antialias = world::Antialias::coverage});
        for (int y = 0; y < size.height; ++y) {
            for (int x = 0; x < size.width; ++x) {
                double seen = 0.0;
                for (int ray = 0; ray < side * side; ++ray) {
                    const glm::dvec3 direction = ray_in_pixel(size, focal, x, y, ray, side);
                    double nearest = std::numeric_limits<double>::infinity();
                    std::size_t shown = 0;
                    for (std::size_t i = 0; i < corners.size(); i += 3) {
                        const double along = distance_along(direction, corners.data() + i);
                        if (along < near_m || along >= nearest) continue;
                        nearest = along;
                        shown = i / 3 + 1;
                    }
                    seen += static_cast<double>(shown) / 16.0 / (side * side);
                }
                const double error = std::abs(linear_of(picture.red(x, y)) - seen);
                squares += error * error;
                worst = std::max(worst, error);
                off += error > 0.05 ? 1 : 0;
                ++count;
            }
        }
    }
    std::printf("rms %.4f, max %.3f, %d of %d pixels off by more than 0.05\n", std::sqrt(squares / count), worst, off,
                count);
    EXPECT_LT(std::sqrt(squares / count), 0.008);
    // Corners lie on a grid of 1/256 of a pixel, which tilts what is seen from its edge: where such cross, the line
    // between them moves.
    EXPECT_LE(off, 5);
    EXPECT_LT(worst, 0.25);
}

/// Half of the light comes through.
world::Material pane_of(glm::vec3 color) {
    world::Material material = colored(color, true);
    material.alpha_mode = world::AlphaMode::blend;
    material.base_color.a = 0.5f;
    material.double_sided = true;
    return material;
}

TEST(Areas, OfWhatIsBlendedAreThoseThatManyRaysSee) {
    // Panes before, behind and through opaque triangles, over each other and over nothing; some of either move.
    constexpr ImageSize size{40, 30};
    constexpr double focal = 30.0;
    constexpr int side = 16;
    double squares = 0.0, worst = 0.0;
    int count = 0;
    for (std::uint64_t round = 0; round < 12; ++round) {
        struct Shape {
            std::vector<glm::vec3> corners;
            float color;
            bool is_pane;
        };
        std::vector<Shape> shapes;
        TestWorld world;
        for (int i = 0; i < 10; ++i) {
            std::uint64_t n = static_cast<std::uint64_t>(i) * 16;
            const auto at = [&](double low, double high) { return low + (high - low) * random(80 + round, n++); };
            // Opaque ones tilt, panes face the camera: no two change places within a pixel.
            const bool is_pane = i >= 5;
            const double distance = is_pane ? 3.0 + i : at(4.0, 12.0);
            Shape shape{{}, static_cast<float>(i + 1) / 16.0f, is_pane};
            for (int k = 0; k < 3; ++k) {
                const double aside = at(-0.6, 0.6), up = at(-0.5, 0.5), nearer = at(-1.0, 1.0);
                const double x = distance + (is_pane ? 0.0 : nearer);
                shape.corners.emplace_back(glm::dvec3(x, aside * x, up * x));
            }
            world::Material material = is_pane ? pane_of({shape.color, 0, 0}) : colored({shape.color, 0, 0}, true);
            material.double_sided = true;
            const auto made =
                instance_of(model_of(triangles(shape.corners), material), {}, static_cast<std::uint32_t>(i + 1));
            (i % 3 == 2 ? world.movers : world.objects).push_back(made);
            shapes.push_back(std::move(shape));
        }
        View view = TestCamera{.size = size, .focal_px = focal, .antialias = world::Antialias::coverage}.view();
        const auto plain = drawer(), layered = drawer(with_layers());
        const auto frame = drawn(*plain, world.snapshot(), {view}).at(0);
        const Picture picture{frame};
        // The second time the layer is in the picture.
        for (int n = 0; n < 2; ++n)
            EXPECT_TRUE(are_equal(frame, drawn(*layered, world.snapshot(), {view}).at(0)))
                << round << ", picture " << n;
        for (int y = 0; y < size.height; ++y) {
            for (int x = 0; x < size.width; ++x) {
                double seen = 0.0;
                for (int ray = 0; ray < side * side; ++ray) {
                    const glm::dvec3 direction = ray_in_pixel(size, focal, x, y, ray, side);
                    std::vector<std::pair<double, const Shape*>> met;
                    for (const Shape& shape : shapes) {
                        const double along = distance_along(direction, shape.corners.data());
                        if (along > 0.0) met.emplace_back(along, &shape);
                    }
                    std::ranges::sort(met);
                    double through = 1.0;
                    for (const auto& [along, shape] : met) {
                        const double share = shape->is_pane ? 0.5 : 1.0;
                        seen += through * share * static_cast<double>(shape->color) / (side * side);
                        through *= 1.0 - share;
                    }
                }
                const double error = std::abs(linear_of(picture.red(x, y)) - seen);
                squares += error * error;
                worst = std::max(worst, error);
                ++count;
            }
        }
    }
    std::printf("rms %.4f, max %.3f\n", std::sqrt(squares / count), worst);
    EXPECT_LT(std::sqrt(squares / count), 0.004);
    EXPECT_LT(worst, 0.06);
}

TEST(Areas, OfMoreLayersThanAPixelTakesAreThoseOfItsMiddle) {
    // An edge of panes goes through the middle columns of pixels, a third of each.
    const auto picture_of = [&](int layers) {
        TestWorld world;
        for (int i = 0; i < layers; ++i) {
            world::Material material = pane_of({1, 1, 1});
            material.base_color.a = 0.1f;
            const float x = 3.0f - 0.01f * static_cast<float>(i);
            // Its right side is seen at 15.5 + 1/3.
            world.objects.push_back(instance_of(model_of(triangles({{x, -x / 96.0f, -9},
                                                                    {x, 9, -9},
                                                                    {x, 9, 9},
                                                                    {x, -x / 96.0f, -9},
                                                                    {x, 9, 9},
                                                                    {x, -x / 96.0f, 9}}),
                                                         material),
                                                {}, static_cast<std::uint32_t>(i + 1)));
        }
        return drawn(world, {.size = {32, 24}, .focal_px = 32.0, .antialias = world::Antialias::coverage});
    };
    for (const int layers : {1, 2, 128, 129}) {
        const Picture picture = picture_of(layers);
        const double all = 1.0 - std::pow(0.9, layers), share = layers <= 128 ? 1.0 / 3.0 : 0.0;
        EXPECT_NEAR(linear_of(picture.red(14, 12)), all, 0.04) << layers;
        EXPECT_NEAR(linear_of(picture.red(16, 12)), share * all, 0.02) << layers;
        EXPECT_EQ(picture.red(17, 12), 0) << layers;
    }
}

TEST(Areas, OfWhatStandsStillShowBeforeAMoverAndNotBehindIt) {
    // A wire, 0.3 of a pixel wide, that the middle of no pixel lies on.
    constexpr double focal = 32.0, middle_px = 15.5, left_px = 8.1, right_px = 8.4;
    world::Material blue = colored({0, 0, 1}, true), red = colored({1, 0, 0}, true);
    blue.double_sided = red.double_sided = true;
    const auto y_of = [&](double x_px) { return -(x_px - middle_px) / focal; };
    for (const double wire_m : {2.0, 3.9, 5.0}) {
        const double mover_m = 4.0, y = 0.5 * (y_of(left_px) + y_of(right_px)) * wire_m;
        const double half = 0.5 * (y_of(left_px) - y_of(right_px)) * wire_m;
        TestWorld world;
        world.objects = {instance_of(model_of(rectangle({wire_m, y, 0}, {0, half, 0}, {0, 0, 9}), blue), {}, 1)};
        world.movers = {instance_of(model_of(rectangle({mover_m, 0, 0}, {0, 9, 0}, {0, 0, 9}), red), {}, 2)};
        const Picture picture =
            drawn(world, {.size = {32, 24}, .focal_px = focal, .antialias = world::Antialias::coverage});
        for (const int row : {5, 12})
            EXPECT_NEAR(linear_of(picture.at(8, row)[2]), wire_m < mover_m ? 0.3 : 0.0, 0.03) << wire_m << " m";
    }
}

TEST(HardGeometry, WhatHasNoAreaOrIsNoNumberIsNotDrawnAndHarmsNothing) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    TestWorld good = gallery();
    const Picture expected = drawn(good, {.size = {97, 61}, .focal_px = 70.0});
    for (const float bad : {nan, inf, -inf, 3e38f, -3e38f}) {
        for (int corner = 0; corner < 8; ++corner) {
            // Some of the coordinates of two corners.
            world::Primitive p = triangles(
                {{2, 0, 0}, {2, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 0, 0}, {2, -1, 0}, {3, 1, 1}, {1, -1, 0}, {2, 1, 0}});
            p.bounds = {glm::vec3(-10.0f), glm::vec3(10.0f)};
            for (int axis = 0; axis < 3; ++axis) {
                if ((corner >> axis & 1) != 0) p.positions[6][axis] = bad;
            }
            if (corner == 0) p.positions[6] = p.positions[7];
            TestWorld world = gallery();
            world.objects.push_back(instance_of(model_of(p, colored({1, 0, 0}, true)), {}, 90));
            const Picture picture = drawn(world, {.size = {97, 61}, .focal_px = 70.0});
            if (corner == 0 || std::isnan(bad)) {
                EXPECT_TRUE(are_equal(picture.frame, expected.frame)) << bad << ", coordinates " << corner;
            }
        }
    }
}

TEST(HardGeometry, TextureCoordinatesMayBeAnyNumber) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    for (const float bad : {nan, inf, -inf, 3e38f, -3e38f, 1e10f, -1e10f, 2147483648.0f, -2147483648.0f, 1.7e7f}) {
        for (const world::Wrap wrap : {world::Wrap::repeat, world::Wrap::clamp_to_edge, world::Wrap::mirrored_repeat}) {
            for (const world::Filter filter : {world::Filter::nearest, world::Filter::linear}) {
                for (const bool mipmaps : {false, true}) {
                    auto model = model_of(rectangle({2, 0, 0}, {0, -1, 0}, {0, 0, 1}), colored(glm::vec3(1.0f), true));
                    model->images.push_back(patterned({37, 20}));
                    model->textures.push_back({.image = 0, .sampler = {wrap, wrap, filter, filter, mipmaps}});
                    model->materials[0].base_color_texture.texture = 0;
                    // All of them; and one, so that the numbers between are large or none, too.
                    auto& at = model->meshes[0].primitives[0].texcoords[0];
                    TestWorld world;
                    at[1].x = bad;
                    world.objects.push_back(instance_of(model));
                    EXPECT_EQ(drawn(world, {.size = {33, 33}, .focal_px = 32}).at(16, 16)[3], 255);
                    at.assign(at.size(), glm::vec2(bad, -bad));
                    world.objects = {instance_of(model)};
                    EXPECT_EQ(drawn(world, {.size = {33, 33}, .focal_px = 32}).at(16, 16)[3], 255);
                }
            }
        }
    }
}

TEST(HardGeometry, AMillionTrianglesAreDrawn) {
    const std::vector<glm::vec3> corners = shaken_grid(1024, 512, 0.2, 0.25, 3);
    ASSERT_EQ(corners.size(), 3u << 20);
    expect_watertight(corners, {128, 96}, 0, "2^20 triangles");
}

TEST(HardGeometry, APrincipalPointFarAsideLeavesNothingOut) {
    // A crop of a larger sensor: whatever draws it, the wall is seen.
    TestWorld world;
    for (const double c : {-7000.0, 7000.0, -9000.0, 9000.0, -1e6, 1e6}) {
        const TestCamera camera{.size = {64, 48}, .intrinsics = camera::Intrinsics{1000.0, 1000.0, c, -c}};
        const double x = (31.5 - c) / 1000.0, y = (23.5 + c) / 1000.0;
        const glm::vec3 middle(glm::dvec3(1.0, -x, -y));
        world.objects = {
            instance_of(model_of(rectangle(middle, {0, -0.1, 0}, {0, 0, 0.1}), colored(glm::vec3(1.0f), true)))};
        const auto by = drawer();
        const View view = camera.view();
        by->begin_instant(world.snapshot());
        if (!by->can_draw(view)) continue;
        EXPECT_LT(std::abs(c), 9000.0) << "cannot be held in 1/256 pixels of 32 bits";
        EXPECT_EQ(drawn(world, camera).red(31, 23), 255) << c;
    }
}

// So say refusals of what is drawn nowhere else.
TEST(HardGeometry, APrincipalPointNoFartherThan8192PixelsFromAnyEdgeIsWithinReach) {
    EXPECT_NE(std::string_view(no_flow).find("no farther than 8192 pixels from any edge"), std::string_view::npos);
    for (const int side : {16, 640, 8192}) {
        for (const double c : {side - 8192.0, 8192.0}) {
            const TestCamera camera{.size = {side, side}, .intrinsics = camera::Intrinsics{1000.0, 1000.0, c, c}};
            EXPECT_TRUE(software::SoftwareDrawer::may_draw(camera.view())) << side << ' ' << c;
        }
    }
}

TEST(SameBytes, AnyNumberOfThreads) {
    Film film("hall");
    std::vector<std::unique_ptr<software::SoftwareDrawer>> drawers;
    for (const int threads : {1, 2, 3}) {
        auto options = with_layers();
        options.threads = threads;
        options.max_detail_error_px = 0.25;
        drawers.push_back(drawer(options));
    }
    // As many views as threads: each thread a view; fewer: all of them together on each.
    std::vector<View> views;
    for (const char* name : {"lobby", "entrance", "gallery"})
        views.push_back(film.view(name, {320 + 7 * static_cast<int>(views.size()), 181},
                                  static_cast<std::uint32_t>(views.size() + 1)));
    views[1].quality = world::Quality::fast;
    for (const std::size_t i : {1u, 2u}) views[i] = with(views[i], world::Antialias::coverage);
    views[0] = with(views[0], world::Antialias::none);
    views[0].quality = world::Quality::beautiful;
    for (int n = 0; n < 4; ++n) {
        const world::SnapshotRef snapshot = film.at(3 * ns_per_s + n * 200 * ns_per_ms);
        const std::vector<View> asked(views.begin(), views.begin() + 3 - n % 3);
        std::vector<std::vector<frame::FrameRef>> results;
        for (const auto& by : drawers) results.push_back(drawn(*by, snapshot, asked));
        for (std::size_t i = 0; i < asked.size(); ++i) {
            EXPECT_TRUE(are_equal(results[0][i], results[1][i])) << "2 threads, instant " << n << ", view " << i;
            EXPECT_TRUE(are_equal(results[0][i], results[2][i])) << "3 threads, instant " << n << ", view " << i;
        }
    }
}

TEST(SameBytes, WhicheverOtherCamerasSeeAPerson) {
    // A small picture takes coarser people than a large one: whose vertices are made when, changes nothing.
    auto options = with_layers();
    options.max_detail_error_px = 0.25;
    options.threads = 2;
    Film film("hall");
    const View large = film.view("lobby", {640, 360}, 1), small = film.view("lobby", {96, 54}, 2),
               middle = film.view("lobby", {240, 135}, 3);
    const auto by = drawer(options);
    for (int n = 0; n < 4; ++n) {
        const world::SnapshotRef snapshot = film.at(3 * ns_per_s + n * 200 * ns_per_ms);
        const auto alone = [&](const View& view) { return drawn(*drawer(options), snapshot, {view}).at(0); };
        const std::array turns{std::vector{small, middle}, std::vector{large}, std::vector{middle}, std::vector{small}};
        std::vector<frame::FrameRef> made = drawn(*by, snapshot, turns[0]);
        for (std::size_t i = 1; i < turns.size(); ++i) by->draw(std::vector<const View*>{&turns[i].front()}, 0, made);
        EXPECT_TRUE(are_equal(made[0], alone(small)) && are_equal(made[4], made[0])) << n;
        EXPECT_TRUE(are_equal(made[1], alone(middle)) && are_equal(made[3], made[1])) << n;
        EXPECT_TRUE(are_equal(made[2], alone(large))) << n;
    }
}

TEST(SameBytes, OfTwoDrawersOnTwoThreadsThatShareWhatIsMadeOfModels) {
    Film film("minimal");
    std::vector<world::SnapshotRef> snapshots;
    for (int n = 0; n < 3; ++n) {
        snapshots.push_back(film.at(3 * ns_per_s + n * 200 * ns_per_ms));
        // Another world between: what is made of its models goes while the other drawer may draw with it.
        snapshots.push_back(gallery().snapshot());
    }
    const std::array<View, 2> views{film.view("main", {160, 90}, 1), film.view("main", {96, 54}, 2)};
    auto options = with_layers();
    options.pool = std::make_shared<frame::FramePool>();
    options.max_detail_error_px = 0.25;
    options.threads = 2;
    const auto film_of = [&](const View& view, const SharedCaches& caches) {
        auto own = options;
        own.caches = caches;
        software::SoftwareDrawer by(own);
        std::vector<frame::FrameRef> frames;
        for (const world::SnapshotRef& snapshot : snapshots) frames.push_back(drawn(by, snapshot, {view}).at(0));
        return frames;
    };
    const SharedCaches shared = make_shared_caches();
    std::array<std::vector<frame::FrameRef>, 2> together;
    {
        const std::jthread other([&] { together[1] = film_of(views[1], shared); });
        together[0] = film_of(views[0], shared);
    }
    for (std::size_t v = 0; v < views.size(); ++v) {
        const auto alone = film_of(views[v], {});
        for (std::size_t n = 0; n < alone.size(); ++n)
            EXPECT_TRUE(are_equal(together[v][n], alone[n])) << "view " << v << ", picture " << n;
    }
}

TEST(Cost, OfEachViewIsItsOwn) {
    auto options = with_layers();
    options.threads = 2;
    const world::SnapshotRef world = gallery().snapshot();
    // As many as threads: a view each. Fewer: in bands, whose times are added.
    for (const bool is_in_bands : {false, true}) {
        const auto by = drawer(options);
        std::vector<View> views{TestCamera{.size = {640, 480}, .focal_px = 400.0}.view(1)};
        if (!is_in_bands) views.push_back(TestCamera{.size = {32, 24}, .focal_px = 20.0}.view(2));
        drawn(*by, world, views);
        ASSERT_EQ(by->cost_ns().size(), views.size());
        for (const TimeNs cost_ns : by->cost_ns()) EXPECT_GT(cost_ns, 0);
        if (!is_in_bands) {
            EXPECT_GT(by->cost_ns()[0], by->cost_ns()[1]) << "has 400 times the pixels";
        }
    }
}

TEST(SameBytes, WithAndWithoutWideLanes) {
    if (!software::has_wide_lanes()) GTEST_SKIP() << "this CPU has none";
    auto options = with_layers();
    const auto wide = drawer(options);
    options.wide_lanes = false;
    const auto narrow = drawer(options);
    Film film("hall");
    const world::SnapshotRef surfaces = gallery().snapshot(), people = film.at(3 * ns_per_s);
    for (const world::Quality quality : {world::Quality::fast, world::Quality::simple, world::Quality::beautiful}) {
        View aside = TestCamera{.size = {321, 243}, .focal_px = 220.0, .quality = quality}.view(1);
        View lobby = with(film.view("lobby", {320, 180}, 2), world::Antialias::none);
        lobby.quality = quality;
        const View areas_aside = numbered(with(aside, world::Antialias::coverage), 3);
        const View areas_lobby = numbered(with(lobby, world::Antialias::coverage), 4);
        for (int n = 0; n < 3; ++n) {
            for (const auto& [snapshot, view] : {std::pair(surfaces, aside), std::pair(people, lobby),
                                                 std::pair(surfaces, areas_aside), std::pair(people, areas_lobby)}) {
                EXPECT_TRUE(are_equal(drawn(*wide, snapshot, {view}).at(0), drawn(*narrow, snapshot, {view}).at(0)))
                    << to_string(quality) << ", camera " << *view.name << ", picture " << n;
            }
        }
    }
}

/// Snapshots of the gallery whose movers go through the picture. The statics are the same ones.
world::SnapshotRef moment(const world::SnapshotRef& first, int n) {
    auto snapshot = std::make_shared<world::Snapshot>(*first);
    snapshot->movers[0].position = {4.0, -1.6 + 0.23 * n, -0.5};
    snapshot->movers[1].position = {2.6 + 0.1 * n, 0.9 - 0.17 * n, -0.2 + 0.05 * n};
    return snapshot;
}

TEST(SameBytes, WithAndWithoutStaticLayersWhateverHappensToTheCameras) {
    const world::SnapshotRef first = gallery().snapshot();
    // Room for two layers of the four.
    const auto kept = drawer(with_layers(2 * 3 * 4 * 168 * 100 + 1000)), full = drawer();
    std::vector<View> views;
    for (std::uint32_t n = 1; n <= 4; ++n)
        views.push_back(TestCamera{.eye = {0.0, 0.1 * n, 0.0}, .size = {161, 100}, .focal_px = 110.0}.view(n));
    for (int n = 0; n < 160; ++n) {
        if (n == 8) kept->forget(views[0].camera);
        if (n == 12) {
            views[0] = TestCamera{.size = {90, 70}, .focal_px = 60.0}.view(1);
        } else if (n == 16) {
            views[1].quality = world::Quality::fast;
        } else if (n == 20) {
            views[1].quality = world::Quality::simple;
            views[2].pose.position.z += 0.1;
        } else if (n == 24) {
            views.erase(views.begin());  // not drawn for longer than a layer is kept: the others have its room
        } else if (n == 150) {
            views.insert(views.begin(), TestCamera{.size = {161, 100}, .focal_px = 110.0}.view(1));
        }
        if (n > 30 && n < 148 && n % 20 != 0) {
            kept->begin_instant(moment(first, n));
            std::vector<frame::FrameRef> unseen;
            kept->draw(std::vector<const View*>{&views[n % 3 == 0]}, 0, unseen);
            continue;
        }
        const world::SnapshotRef snapshot = moment(first, n % 20);
        const auto a = drawn(*kept, snapshot, views), b = drawn(*full, snapshot, views);
        ASSERT_EQ(a.size(), views.size());
        for (std::size_t i = 0; i < a.size(); ++i)
            ASSERT_TRUE(are_equal(a[i], b[i])) << "instant " << n << ", view " << i;
    }
    const RenderCounters counters = kept->counters();
    EXPECT_GT(counters.layers_reused, 50u);
    EXPECT_GT(counters.layers_stale, 0u);
    EXPECT_GT(counters.layers_evicted, 0u);
    EXPECT_EQ(full->counters().layers_reused, 0u);
}

/// With layers, without, and with so little room that none is kept; how the camera `own` sees the gallery and `lobby`
/// the hall.
void expect_that_layers_change_nothing(TestCamera own, world::Quality quality, world::Antialias antialias,
                                       std::int64_t too_little) {
    Film film("hall");
    const world::SnapshotRef first = gallery().snapshot();
    own.quality = quality;
    own.antialias = antialias;
    const View aside = own.view(1);
    View lobby = with(film.view("lobby", {320, 240}, 2), antialias);
    lobby.quality = quality;
    for (const View& view : {aside, lobby}) {
        auto options = with_layers();
        options.threads = 2;
        const auto kept = drawer(options), full = drawer(), cramped = drawer(with_layers(too_little));
        for (int n = 0; n < 8; ++n) {
            const bool is_aside = view.camera == aside.camera;
            const world::SnapshotRef now = is_aside ? moment(first, n) : film.at(3 * ns_per_s + n * 130 * ns_per_ms);
            const frame::FrameRef whole = drawn(*full, now, {view}).at(0);
            EXPECT_TRUE(are_equal(drawn(*kept, now, {view}).at(0), whole)) << "instant " << n;
            EXPECT_TRUE(are_equal(drawn(*cramped, now, {view}).at(0), whole)) << "instant " << n << ", little room";
        }
        EXPECT_EQ(kept->counters().layers_reused, 6u);
        if (quality == world::Quality::beautiful) {
            EXPECT_EQ(cramped->counters().layers_reused, 0u);
        }
        kept->forget(view.camera);
        EXPECT_EQ(kept->counters().layer_bytes, 0);
    }
}

TEST(SameBytes, OfShadowsWithAndWithoutStaticLayers) {
    // Room for the pictures of a layer, but not for what shades it anew.
    expect_that_layers_change_nothing({.size = {161, 100}, .focal_px = 110.0}, world::Quality::beautiful,
                                      world::Antialias::none, 4 * 4 * 168 * 100 + 1000);
}

TEST(SameBytes, OfAreasWithAndWithoutStaticLayers) {
    expect_that_layers_change_nothing({.size = {161, 100}, .focal_px = 110.0}, world::Quality::simple,
                                      world::Antialias::coverage, 4 * 4 * 168 * 100 + 5000);
}

TEST(SameBytes, WhateverTheMemoryOfAFrameHeld) {
    // Frames are given back after no, few and many instants: memory comes back with the last picture of its camera, an
    // older one, one of before a change, another camera's, or none.
    const world::SnapshotRef first = gallery().snapshot();
    const auto kept = drawer(with_layers()), full = drawer();
    std::vector<View> views;
    for (const int width : {160, 161, 160}) {
        const auto number = static_cast<std::uint32_t>(views.size() + 1);
        views.push_back(
            TestCamera{.eye = {0.0, 0.1 * number, 0.0}, .size = {width, 100}, .focal_px = 110.0}.view(number));
    }
    const auto change = [](View& view, auto change_spec) {
        auto spec = std::make_shared<world::CameraSpec>(*view.spec);
        change_spec(*spec);
        view.spec = spec;
        view.spec_revision += 1000;
    };
    std::vector<frame::FrameRef> held;
    int reused = 0;
    for (int n = 0; n < 90; ++n) {
        for (View& view : views) view.sequence = 3 * n;
        if (n == 20) change(views[0], [](world::CameraSpec& spec) { spec.controls.brightness = 0.2; });
        if (n == 35) change(views[0], [](world::CameraSpec& spec) { spec.controls.brightness = 0.0; });
        if (n == 40) change(views[2], [](world::CameraSpec& spec) { spec.code_strip = true; });
        if (n == 65) kept->forget(views[2].camera);
        if (n == 75) views[0].pose.position.z += 0.1;
        const world::SnapshotRef snapshot = moment(first, n % 17);
        const auto a = drawn(*kept, snapshot, views), b = drawn(*full, snapshot, views);
        for (std::size_t i = 0; i < a.size(); ++i) {
            ASSERT_TRUE(are_equal(a[i], b[i])) << "instant " << n << ", view " << i;
            reused += a[i]->held_before() != 0;
            if (random(7, static_cast<std::uint64_t>(3 * n) + i) < 0.5) held.push_back(a[i]);
        }
        while (held.size() > 7 || (n % 10 == 9 && !held.empty())) {
            const double pick = random(8, static_cast<std::uint64_t>(n)) * static_cast<double>(held.size());
            held.erase(held.begin() + static_cast<std::ptrdiff_t>(pick));
        }
    }
    EXPECT_GT(reused, 60) << "of 270";
}

TEST(Blending, WhatIsFartherIsDrawnFirst) {
    const auto pane = [](double distance_m, glm::vec3 color, std::uint32_t id) {
        return instance_of(model_of(rectangle(glm::vec3(0.0f), {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f}), pane_of(color)),
                           {distance_m, 0.0, 0.0}, id);
    };
    const world::Instance red = pane(3.0, {1.0f, 0.0f, 0.0f}, 1), green = pane(2.0, {0.0f, 1.0f, 0.0f}, 2);
    for (const bool has_movers : {false, true}) {
        for (const bool red_first : {false, true}) {
            TestWorld world;
            world.objects = {red_first ? red : green};
            (has_movers ? world.movers : world.objects).push_back(red_first ? green : red);
            const auto by = drawer(with_layers());
            View view = TestCamera{.size = {64, 48}, .focal_px = focal_px}.view();
            for (int n = 0; n < 4; ++n) {
                const Picture picture{drawn(*by, world.snapshot(), {view}).at(0)};
                EXPECT_EQ(picture.at(32, 24)[0], srgb_code(0.25)) << has_movers << red_first << ", picture " << n;
                EXPECT_EQ(picture.at(32, 24)[1], srgb_code(0.5)) << has_movers << red_first << ", picture " << n;
            }
        }
    }
}

TEST(FrameDamage, OfTheHallIsAllThatChanged) {
    Film film("hall");
    const auto by = drawer(with_layers());
    std::vector<View> views;
    for (const char* name : {"lobby", "entrance", "gallery"})
        views.push_back(film.view(name, {320, 240}, static_cast<std::uint32_t>(views.size() + 1)));
    auto striped = std::make_shared<world::CameraSpec>(*views[1].spec);
    striped->code_strip = true;
    views[1].spec = striped;
    Claims claims;
    for (int n = 0; n < 50; ++n) {
        for (View& view : views) view.sequence = 10 + n;
        if (n == 20) {
            auto spec = std::make_shared<world::CameraSpec>(*views[0].spec);
            spec->controls.brightness = 0.2;
            views[0].spec = spec;
            views[0].spec_revision += 1000;
        }
        if (n == 30) views[2].pose.position.z += 0.2;
        for (const frame::FrameRef& frame : drawn(*by, film.at(2 * ns_per_s + n * 40 * ns_per_ms), views))
            claims.check(frame, *frame->info().camera + ", instant " + std::to_string(n));
    }
    EXPECT_EQ(claims.count, 150);
    // All but those before and when a layer is made, shown for the first time: three cameras, two changes.
    EXPECT_GE(claims.named, 150 - 3 * 5);
    EXPECT_GT(claims.unchanged_share(), 0.1) << "people are not everywhere";
    EXPECT_LT(claims.unchanged_share(), 0.95) << "but somewhere";
}

TEST(FrameDamage, IsWhereMoversWereAndAre) {
    TestWorld world = gallery();
    const world::SnapshotRef first = world.snapshot();
    const auto by = drawer(with_layers());
    View view = TestCamera{.size = {320, 240}, .focal_px = 200.0}.view();
    Claims claims;
    for (int n = 0; n < 30; ++n) {
        view.sequence = n;
        auto snapshot = std::make_shared<world::Snapshot>(*first);
        // Up, away, and back: nothing moves in some instants, nothing is there in others.
        snapshot->movers[0].position = {4.0, 0.0, -1.0 + 0.3 * (n / 2 % 8)};
        snapshot->movers[1].position = {3.0, 0.5, n % 5 == 0 ? 50.0 : 0.2};
        for (world::Instance& mover : snapshot->movers) mover.scale *= 0.3;
        if (n == 15) {
            // Another world with the same things in it: nothing is known of it.
            auto statics = std::make_shared<world::StaticSet>(*first->statics);
            statics->environment.background = {0.9f, 0.1f, 0.1f};
            snapshot->statics = statics;
        }
        claims.check(drawn(*by, snapshot, {view}).at(0), "instant " + std::to_string(n));
    }
    EXPECT_GT(claims.unchanged_share(), 0.4);
    EXPECT_GE(claims.named, 20);
}

}  // namespace
}  // namespace camrig::render
