#include "core/camera/camera_model.h"

#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <limits>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/unit/camera/random_lens.h"

namespace camrig::camera::camera_model_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double deg = pi / 180.0;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();
constexpr ImageSize full_hd{1920, 1080};
constexpr Intrinsics focal_1050{1050, 1048, 961.3, 537.8};
const Lens mild{LensModel::plumb_bob, {-0.28, 0.08, 8e-4, -5e-4, -0.005}};
const Lens fold_in_the_corner{LensModel::plumb_bob, {-0.32, 0.13, 0, 0, -0.025}};

CameraModel model_of(ImageSize size, const Intrinsics& k, const Lens& lens) {
    auto camera = CameraModel::create(size, k, lens);
    if (!camera) throw std::runtime_error(camera.error().message);
    return *camera;
}

glm::dvec3 direction(double theta, double phi) {
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

TEST(CameraModel, ProjectsWhereOpenCvDoes) {
    std::ifstream file("tests/unit/camera/opencv_reference.txt");
    ASSERT_TRUE(file) << "run from the root of the repository";
    std::optional<CameraModel> camera;
    std::string line;
    int lenses = 0, points = 0;
    double worst = 0.0, worst_ray = 0.0;
    while (std::getline(file, line)) {
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "lens") {
            Intrinsics k;
            words >> word >> k.fx >> k.fy >> k.cx >> k.cy;
            std::vector<double> coefficients;
            for (double c; words >> c;) coefficients.push_back(c);
            const auto lens = make_lens(*parse_name<LensModel>(word), coefficients);
            ASSERT_TRUE(lens) << line;
            camera = model_of(full_hd, k, *lens);
            ++lenses;
        } else if (word == "point") {
            glm::dvec3 p;
            glm::dvec2 expected;
            words >> p.x >> p.y >> p.z >> expected.x >> expected.y;
            const auto pixel = camera->project(p);
            ASSERT_TRUE(pixel) << line;
            worst = std::max(worst, glm::length(*pixel - expected));
            const auto ray = camera->ray(expected);
            ASSERT_TRUE(ray) << line;
            // At a fold a rounding of the pixel moves the ray by its square root.
            worst_ray = std::max(worst_ray, glm::length(*ray - glm::normalize(p)));
            ++points;
        }
    }
    std::printf("%d lenses, %d points: worst %.2e px, worst ray %.2e rad\n", lenses, points, worst, worst_ray);
    EXPECT_GE(lenses, 17);
    EXPECT_GE(points, 16 * 17);
    EXPECT_LT(worst, 1e-9);
    EXPECT_LT(worst_ray, 1e-10);
}

TEST(CameraModel, PinholeKnownAnswers) {
    const CameraModel camera = model_of({640, 480}, {500, 400, 320, 240}, {});
    EXPECT_EQ(camera.project({1, -2, 10}), glm::dvec2(370, 160));
    EXPECT_EQ(camera.project({0, 0, 1e-300}), glm::dvec2(320, 240));
    const auto ray = camera.ray({820, 640});
    ASSERT_TRUE(ray);
    EXPECT_LT(glm::length(*ray - glm::normalize(glm::dvec3(1, 1, 1))), 1e-15);
    EXPECT_TRUE(camera.every_pixel_valid());
    EXPECT_FALSE(camera.lens().folds());
    EXPECT_NEAR(camera.max_field_angle(), std::atan(std::hypot(320.5 / 500, 240.5 / 400)), 1e-15);
    EXPECT_FALSE(camera.project({0, 0, 0}));
    EXPECT_FALSE(camera.project({0, 0, -1}));
    EXPECT_FALSE(camera.project({nan, 0, 1}));
    EXPECT_FALSE(camera.project({inf, 0, 1}));
    EXPECT_FALSE(camera.project({1, 0, 5e-324}));
    EXPECT_FALSE(camera.ray({nan, 0}));
    EXPECT_FALSE(camera.ray({0, -inf}));
}

TEST(CameraModel, ThePictureEndsHalfAPixelOutsideOfTheOuterCentres) {
    const CameraModel camera = model_of({640, 480}, {500, 500, 319.5, 239.5}, {});
    EXPECT_TRUE(camera.in_image({-0.5, -0.5}));
    EXPECT_TRUE(camera.in_image({639.49, 479.49}));
    EXPECT_FALSE(camera.in_image({639.5, 0}));
    EXPECT_FALSE(camera.in_image({0, 479.5}));
    EXPECT_FALSE(camera.in_image({-0.51, 0}));
    EXPECT_FALSE(camera.in_image({nan, 0}));
}

TEST(CameraModel, FieldOfViewFromATenthTo179DegreesKeepsItsRays) {
    for (const double fov : {0.1, 1.0, 60.0, 150.0, 179.0}) {
        const auto k = intrinsics_from_hfov(full_hd, fov * deg);
        ASSERT_TRUE(k);
        const CameraModel camera = model_of(full_hd, *k, {});
        Draw draw(3);
        for (int i = 0; i < 2000; ++i) {
            const glm::dvec2 pixel(draw.uniform(-0.5, 1919.5), draw.uniform(-0.5, 1079.5));
            const auto ray = camera.ray(pixel);
            ASSERT_TRUE(ray);
            const auto again = camera.project(*ray * 1e3);
            ASSERT_TRUE(again);
            ASSERT_LT(glm::length(*again - pixel), 1e-9) << fov;
        }
    }
}

TEST(CameraModel, EveryPixelOfEveryModelComesBack) {
    int valid = 0, invalid = 0;
    double worst = 0.0;
    for (std::uint64_t n = 0; n < 600; ++n) {
        Draw draw(n);
        const Intrinsics k{draw.uniform(300, 2000), draw.uniform(300, 2000), draw.uniform(0, 1920),
                           draw.uniform(0, 1080)};
        const auto camera = CameraModel::create(full_hd, k, random_lens(n));
        ASSERT_TRUE(camera) << n << (camera ? "" : camera.error().message);
        const double cone = std::cos(std::min(pi, camera->max_field_angle() + 1e-9));
        for (int i = 0; i < 200; ++i) {
            const glm::dvec2 pixel(draw.uniform(-0.5, 1919.5), draw.uniform(-0.5, 1079.5));
            const auto ray = camera->ray(pixel);
            if (!ray) {
                ++invalid;
                ASSERT_FALSE(camera->every_pixel_valid()) << n;
                continue;
            }
            ++valid;
            ASSERT_NEAR(glm::length(*ray), 1.0, 1e-15);
            ASSERT_GE(ray->z, cone) << "outside of the cone of max_field_angle, lens " << n;
            const auto again = camera->project(*ray * 7.0);
            if (!again) continue;  // a ray within rounding of the fold
            worst = std::max(worst, glm::length(*again - pixel));
        }
    }
    std::printf("%d pixels with a ray, %d beyond the fold, worst %.2e px\n", valid, invalid, worst);
    EXPECT_GT(valid, 90000);
    EXPECT_GT(invalid, 1000);
    EXPECT_LT(worst, 1e-8);
}

TEST(CameraModel, ALensThatFoldsInsideThePictureMasksItsCorners) {
    const CameraModel camera = model_of(full_hd, {700, 700, 959.5, 539.5}, fold_in_the_corner);
    EXPECT_FALSE(camera.every_pixel_valid());
    EXPECT_TRUE(camera.lens().folds());
    EXPECT_NEAR(camera.max_field_angle(), 57.3 * deg, 0.05 * deg);
    EXPECT_TRUE(camera.ray({959.5, 539.5}));
    for (const glm::dvec2 corner : {glm::dvec2(0, 0), glm::dvec2(1919, 0), glm::dvec2(0, 1079), glm::dvec2(1919, 1079)})
        EXPECT_FALSE(camera.ray(corner));
    // What lies beyond the fold cone has no pixel, although the polynomial would put it into the picture again.
    const glm::dvec3 beyond = direction(65 * deg, 0.3);
    EXPECT_FALSE(camera.project(beyond));
    EXPECT_TRUE(camera.project(direction(57 * deg, 0.3)));
}

TEST(CameraModel, AFisheyeOf220DegreesSeesBehindItself) {
    // 110 deg at the shorter half side: 1024 px across 220 deg.
    const double f = 512.0 / (110 * deg);
    const CameraModel camera =
        model_of({1024, 1024}, {f, f, 511.5, 511.5}, {LensModel::equidistant, {0.01, -0.002, 0, 0}});
    for (double phi = 0; phi < 6.2; phi += 0.1) {
        for (const double theta : {1e-9, 45.0, 89.9999, 90.0, 90.0001, 109.0}) {
            const glm::dvec3 d = direction(theta * deg, phi);
            const auto pixel = camera.project(d * 20.0);
            ASSERT_TRUE(pixel);
            const auto ray = camera.ray(*pixel);
            ASSERT_TRUE(ray);
            ASSERT_LT(glm::length(*ray - d), 1e-13);
        }
    }
    // The corners are 45 % further out than the sides: 159 deg.
    EXPECT_TRUE(camera.every_pixel_valid());
    EXPECT_GT(camera.max_field_angle(), 150 * deg);
    EXPECT_FALSE(camera.project({0, 0, -1}));
}

TEST(CameraModel, ACircularFisheyeLeavesTheCornersBlack) {
    const double f = 500.0 / pi;  // the whole sphere within 500 px of the centre
    const CameraModel camera = model_of({1920, 1080}, {f, f, 959.5, 539.5}, {LensModel::equidistant, {}});
    EXPECT_FALSE(camera.every_pixel_valid());
    EXPECT_EQ(camera.max_field_angle(), pi);
    EXPECT_FALSE(camera.lens().folds());
    EXPECT_TRUE(camera.ray({959.5 + 499, 539.5}));
    EXPECT_FALSE(camera.ray({959.5 + 501, 539.5}));
}

TEST(CameraModel, BadCamerasAreRefusedWithTheReason) {
    const auto reason = [](ImageSize size, const Intrinsics& k, const Lens& lens) {
        const auto camera = CameraModel::create(size, k, lens);
        EXPECT_FALSE(camera);
        return camera ? std::string() : camera.error().message;
    };
    EXPECT_NE(reason({0, 480}, focal_1050, {}).find("size"), std::string::npos);
    EXPECT_NE(reason({640, 9000}, focal_1050, {}).find("8192"), std::string::npos);
    EXPECT_NE(reason(full_hd, {nan, 1050, 960, 540}, {}).find("fx"), std::string::npos);
    EXPECT_NE(reason(full_hd, {1050, -1, 960, 540}, {}).find("fy"), std::string::npos);
    EXPECT_NE(reason(full_hd, focal_1050, {LensModel::plumb_bob, {nan}}).find("finite"), std::string::npos);
    EXPECT_NE(reason(full_hd, focal_1050, {LensModel::plumb_bob, {-1e7}}).find("no rising branch"), std::string::npos);
    // The principal point of a larger sensor, far outside of what this lens shows.
    EXPECT_NE(reason({640, 480}, {700, 700, 5000, 240}, fold_in_the_corner).find("no pixel"), std::string::npos);
}

// Speed is a property others build on (a map of 1080p is filled when a camera is made or changed): a generous bound
// that still fails if the inverse turns into hundreds of steps. The numbers are printed; builds with sanitizers are
// slower.
TEST(CameraModel, AMapOf1080pIsFilledInWellUnderASecond) {
    const struct {
        const char* name;
        Lens lens;
    } lenses[] = {
        {"pinhole", {}},
        {"plumb_bob", {LensModel::plumb_bob, {-0.28, 0.08, 0, 0, -0.005}}},
        {"plumb_bob, tangential", mild},
        {"plumb_bob, fold in the picture", {LensModel::plumb_bob, {-0.45, 0.25, 1e-3, 2e-3, -0.08}}},
        {"rational_polynomial", {LensModel::rational_polynomial, {12.5, 6.1, 2e-4, -1e-4, 0.4, 12.9, 9.8, 1.7}}},
        {"equidistant", {LensModel::equidistant, {0.05, -0.01, 0.003, -0.0006}}}};
    for (const auto& [name, lens] : lenses) {
        const CameraModel camera = model_of(full_hd, focal_1050, lens);
        const std::clock_t start = std::clock();  // processor time: other programs do not count
        double sum = 0.0;
        for (int y = 0; y < 1080; ++y)
            for (int x = 0; x < 1920; ++x)
                if (const auto ray = camera.ray({x, y})) sum += ray->z;
        const double took = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
        std::printf("%-32s %6.1f ms (%.0f ns a pixel), mean z %.3f\n", name, took * 1e3, took * 1e9 / (1920 * 1080),
                    sum / (1920 * 1080));
        EXPECT_LT(took, 20.0) << name;
    }
}

}  // namespace
}  // namespace camrig::camera::camera_model_test
