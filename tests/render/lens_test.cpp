#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "tests/render/support/targets.h"

namespace camrig::render {
namespace {

constexpr camera::Lens barrel{camera::LensModel::plumb_bob, {-0.32, 0.13, 0, 0, -0.025}};
constexpr camera::Lens fisheye{camera::LensModel::equidistant, {-0.01, 0.002, 0, 0}};

TestCamera barrel_camera() {
    return {.size = {320, 240}, .focal_px = 196, .lens = barrel};
}
/// 200 deg across its height.
TestCamera fisheye_camera() {
    return {.size = {320, 240}, .focal_px = 69, .lens = fisheye};
}

template <typename T>
std::vector<T> values_of(const frame::FrameRef& frame) {
    std::vector<T> values(frame->bytes().size() / sizeof(T));
    std::memcpy(values.data(), frame->bytes().data(), frame->bytes().size());
    return values;
}

std::size_t index_of(const TestCamera& camera, int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.size.width) + static_cast<std::size_t>(x);
}

/// A sphere around the camera, its colour a linear function of direction and its normals inwards.
TestWorld surrounded() {
    world::Primitive sphere;
    constexpr int rows = 60, columns = 120;
    for (int i = 0; i <= rows; ++i) {
        for (int j = 0; j <= columns; ++j) {
            const double a = glm::radians(180.0 * i / rows), b = glm::radians(360.0 * j / columns);
            const glm::dvec3 d(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
            sphere.positions.push_back(glm::vec3(5.0 * d));
            sphere.normals.push_back(glm::vec3(-d));
            sphere.colors.push_back(glm::vec4(glm::vec3(0.5 + 0.4 * d), 1.0f));
        }
    }
    for (std::uint32_t i = 0; i < rows; ++i) {
        for (std::uint32_t j = 0; j < columns; ++j) {
            const std::uint32_t a = i * (columns + 1) + j, b = a + columns + 1;
            for (const std::uint32_t corner : {a, a + 1, b, b, a + 1, b + 1}) sphere.indices.push_back(corner);
        }
    }
    world::Material material = colored(glm::vec3(1.0f), true);
    material.double_sided = true;
    TestWorld world;
    world.objects = {instance_of(model_of(std::move(sphere), material))};
    return world;
}

TEST(Lens, PixelsBeyondTheFoldAreBlackAndSeeNothing) {
    const TestCamera camera = barrel_camera();
    const camera::CameraModel model = camera.model();
    ASSERT_FALSE(model.every_pixel_valid());
    TestWorld world = surrounded();
    world.environment.background = glm::vec3(1.0f);
    const Picture picture = draw(world, camera);
    const auto depth = values_of<float>(draw_kind(world, camera, frame::FrameKind::depth));
    const auto ids = values_of<std::uint32_t>(draw_kind(world, camera, frame::FrameKind::instance));
    const auto normals = values_of<float>(draw_kind(world, camera, frame::FrameKind::normal));
    int masked = 0;
    for (int y = 0; y < camera.size.height; ++y) {
        for (int x = 0; x < camera.size.width; ++x) {
            const std::size_t i = index_of(camera, x, y);
            const bool sees = model.ray({x, y}).has_value();
            masked += !sees;
            ASSERT_EQ(picture.at(x, y) != (std::array{0, 0, 0, 255}), sees) << x << "," << y;
            ASSERT_EQ(std::isfinite(depth[i]), sees) << x << "," << y;
            ASSERT_EQ(ids[i], sees ? 1u : 0u) << x << "," << y;
            ASSERT_EQ(normals[3 * i] != 0 || normals[3 * i + 1] != 0 || normals[3 * i + 2] != 0, sees);
        }
    }
    EXPECT_GT(masked, 4);
}

TEST(Lens, EveryPixelShowsTheColourOfItsOwnDirection) {
    for (const TestCamera& camera : {barrel_camera(), fisheye_camera()}) {
        const camera::CameraModel model = camera.model();
        const Picture picture = draw(surrounded(), camera);
        for (int y = 0; y < camera.size.height; ++y) {
            for (int x = 0; x < camera.size.width; ++x) {
                const auto ray = model.ray({x, y});
                if (!ray) continue;
                const glm::dvec3 d(ray->z, -ray->x, -ray->y);
                for (int channel = 0; channel < 3; ++channel) {
                    ASSERT_NEAR(picture.at(x, y)[channel], srgb_code(0.5 + 0.4 * d[channel]), 1.5) << x << "," << y;
                }
            }
        }
    }
}

// Second differences of the smooth picture: a seam that shows is a step of more than rounding.
TEST(Lens, FacesOfTheCubeMeetWithoutASeam) {
    for (const world::Antialias antialias : {world::Antialias::none, world::Antialias::ssaa2}) {
        TestCamera camera = fisheye_camera();
        camera.antialias = antialias;
        const Picture picture = draw(surrounded(), camera);
        int worst = 0;
        for (int y = 1; y + 1 < camera.size.height; ++y) {
            for (int x = 1; x + 1 < camera.size.width; ++x) {
                for (int channel = 0; channel < 3; ++channel) {
                    const int middle = 2 * picture.at(x, y)[channel];
                    worst = std::max(
                        {worst, std::abs(picture.at(x - 1, y)[channel] + picture.at(x + 1, y)[channel] - middle),
                         std::abs(picture.at(x, y - 1)[channel] + picture.at(x, y + 1)[channel] - middle)});
                }
            }
        }
        EXPECT_LE(worst, 3) << to_string(antialias);
    }
}

TEST(Lens, DepthIsMetresAlongTheOpticalAxisWhateverFaceItIsSeenIn) {
    // A wall 2 m in front, so large that it reaches 89 deg; and one as far behind.
    TestWorld world;
    world::Material both = colored(glm::vec3(1.0f), true);
    both.double_sided = true;
    world.objects = {instance_of(model_of(rectangle({2, 0, 0}, {0, -400, 0}, {0, 0, 400}), both), {}, 1),
                     instance_of(model_of(rectangle({-2, 0, 0}, {0, -400, 0}, {0, 0, 400}), both), {}, 2)};
    for (const TestCamera& camera : {barrel_camera(), fisheye_camera()}) {
        const camera::CameraModel model = camera.model();
        View view = camera.view();
        view.kinds[static_cast<int>(frame::FrameKind::depth)] = true;
        const auto with_color = values_of<float>(draw_views(world.snapshot(), {&view, 1}).at(1));
        const auto alone = values_of<float>(draw_kind(world, camera, frame::FrameKind::depth));
        ASSERT_EQ(with_color, alone);
        int before = 0, behind = 0;
        for (int y = 0; y < camera.size.height; ++y) {
            for (int x = 0; x < camera.size.width; ++x) {
                const auto ray = model.ray({x, y});
                if (!ray || std::abs(ray->z) < 0.05) continue;
                ASSERT_NEAR(alone[index_of(camera, x, y)], ray->z > 0 ? 2.0 : -2.0, 1e-4) << x << "," << y;
                (ray->z > 0 ? before : behind) += 1;
            }
        }
        EXPECT_GT(before, 10000);
        EXPECT_EQ(behind > 10000, camera.lens.model == camera::LensModel::equidistant);
    }
}

TEST(Lens, NormalsAreInTheOpticalFrameWhateverFaceTheyAreSeenIn) {
    const TestCamera camera = fisheye_camera();
    const camera::CameraModel model = camera.model();
    const auto normals = values_of<float>(draw_kind(surrounded(), camera, frame::FrameKind::normal));
    for (int y = 0; y < camera.size.height; ++y) {
        for (int x = 0; x < camera.size.width; ++x) {
            const auto ray = model.ray({x, y});
            if (!ray) continue;
            const std::size_t i = 3 * index_of(camera, x, y);
            const glm::dvec3 n(normals[i], normals[i + 1], normals[i + 2]);
            // Nearest texel: up to a pixel's diagonal away, 1/69 rad.
            ASSERT_GT(glm::dot(n, -*ray), 0.9997) << x << "," << y;
        }
    }
}

TEST(Lens, IdsAgreeWithTheColourOfTheSamePixel) {
    for (TestCamera camera : {barrel_camera(), fisheye_camera()}) {
        camera.lens_sampling.filter = world::LensFilter::bilinear;
        const camera::CameraModel model = camera.model();
        std::vector<Disc> discs;
        for (int y = 20; y < 220; y += 40) {
            for (int x = 20; x < 300; x += 40) {
                if (const auto disc = disc_at(model, {x + 0.3, y + 0.1}, 3.0, 9.0)) discs.push_back(*disc);
            }
        }
        const TestWorld world = world_of(discs);
        const Picture picture = draw(world, camera);
        const auto ids = values_of<std::uint32_t>(draw_kind(world, camera, frame::FrameKind::instance));
        for (int y = 0; y < camera.size.height; ++y) {
            for (int x = 0; x < camera.size.width; ++x) {
                const std::uint32_t id = ids[index_of(camera, x, y)];
                const bool agrees = id == 0 ? picture.red(x, y) < 255 : picture.red(x, y) > 0;
                ASSERT_TRUE(agrees) << x << "," << y;
                if (id == 0) continue;
                // What is seen is the disc itself, not its neighbour.
                const Disc& disc = discs.at(id - 1);
                const glm::dvec3 ray = *model.ray({x, y});
                const double off = glm::length(glm::cross(ray, glm::normalize(disc.centre)));
                ASSERT_LT(off, 1.25 * glm::length(disc.across) / 3.0 + 0.02) << x << "," << y;
            }
        }
    }
}

TEST(Lens, ALensThatChangesNothingIsThePinholePicture) {
    TestWorld world = surrounded();
    world.objects.push_back(instance_of(model_of(box(glm::vec3(0.4f)), colored({0.1f, 0.9f, 0.3f})), {3, 0.4, 0.2}, 5));
    const TestCamera pinhole{.size = {160, 120}, .focal_px = 150};
    const Picture direct = draw(world, pinhole);
    for (const world::LensFilter filter : {world::LensFilter::bilinear, world::LensFilter::bicubic}) {
        TestCamera warped = pinhole;
        warped.lens_sampling = {.method = world::LensMethod::warp, .filter = filter};
        const Picture through = draw(world, warped);
        int different = 0;
        for (int y = 0; y < 120; ++y) {
            for (int x = 0; x < 160; ++x) different += direct.at(x, y) != through.at(x, y);
        }
        // Another frustum rounds otherwise: an edge may pass a pixel's centre on the other side, a colour be one off.
        EXPECT_LT(different, 40) << to_string(filter);
    }
}

TEST(Lens, MethodsAgreeWithEachOther) {
    const TestWorld world = surrounded();
    TestCamera camera{.size = {320, 240}, .focal_px = 150, .lens = {camera::LensModel::equidistant, {0.01, 0, 0, 0}}};
    camera.lens_sampling.method = world::LensMethod::warp;
    const Picture plane = draw(world, camera);
    camera.lens_sampling.method = world::LensMethod::cube;
    const Picture faces = draw(world, camera);
    for (int y = 0; y < 240; ++y) {
        for (int x = 0; x < 320; ++x) {
            for (int channel = 0; channel < 3; ++channel) {
                ASSERT_NEAR(plane.at(x, y)[channel], faces.at(x, y)[channel], 1) << x << "," << y;
            }
        }
    }
}

TEST(Lens, AForcedPlaneThatCannotHoldThePictureIsAnErrorThatSaysWhatCan) {
    TestCamera camera = fisheye_camera();
    camera.lens_sampling.method = world::LensMethod::warp;
    const View view = camera.view();
    Renderer& renderer = cpu_renderer();
    const auto finished = renderer.draw(TestWorld{}.snapshot(), 0, {&view, 1});
    ASSERT_TRUE(finished.has_value());
    ASSERT_EQ(finished->failures.size(), 1u);
    EXPECT_NE(finished->failures[0].error.message.find("use auto or cube"), std::string::npos);
}

TEST(Lens, ACameraThatTurnsKeepsItsLensAndOneThatGetsAnotherLensShowsIt) {
    const TestWorld world = surrounded();
    const Picture first = draw(world, barrel_camera());
    TestCamera other = barrel_camera();
    other.lens.coefficients[0] = -0.2;
    const Picture second = draw(world, other);
    const Picture again = draw(world, barrel_camera());
    EXPECT_FALSE(std::ranges::equal(first.frame->bytes(), second.frame->bytes()));
    EXPECT_TRUE(std::ranges::equal(first.frame->bytes(), again.frame->bytes()));
}

}  // namespace
}  // namespace camrig::render
