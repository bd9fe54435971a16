// Where things appear through a lens, against CameraModel::project in double.

#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>

#include "tests/render/support/targets.h"

namespace camrig::render {
namespace {

struct LensCase {
    const char* name;
    camera::Lens lens;
    camera::Intrinsics intrinsics;
};

constexpr ImageSize picture_size{640, 480};

const LensCase lens_cases[] = {
    {"weak", {camera::LensModel::plumb_bob, {-0.05, 0.01, 0, 0, 0}}, {520, 520, 319.5, 239.5}},
    {"strong barrel", {camera::LensModel::plumb_bob, {-0.35, 0.15, 0, 0, -0.03}}, {420, 420, 319.5, 239.5}},
    {"pincushion", {camera::LensModel::plumb_bob, {0.3, 0.1, 0, 0, 0.02}}, {450, 450, 319.5, 239.5}},
    {"tangential", {camera::LensModel::plumb_bob, {-0.1, 0.02, 0.012, -0.009, 0}}, {480, 480, 319.5, 239.5}},
    {"off centre, oblong pixels",
     {camera::LensModel::plumb_bob, {-0.2, 0.05, 1e-3, -5e-4, 0}},
     {611.3, 487.9, 281.7, 265.2}},
    {"rational",
     {camera::LensModel::rational_polynomial, {0.4, 0.1, 4e-4, -3e-4, 0.01, 0.75, 0.25, 0.03}},
     {400, 402, 322, 236}},
    {"fold just inside the corner",
     {camera::LensModel::plumb_bob, {-0.32, 0.13, 0, 0, -0.025}},
     {404, 404, 319.5, 239.5}},
    {"fisheye, 120 deg", {camera::LensModel::equidistant, {0.02, -0.01, 0.002, 0}}, {380, 380, 319.5, 239.5}},
    {"fisheye, 200 deg", {camera::LensModel::equidistant, {-0.01, 0.002, 0, 0}}, {138, 138, 319.5, 239.5}},
};

struct Worst {
    double error = 0.0;
    int seen = 0;
};

/// Cosine of 115 deg: no lens sees further, though the model goes on to 180.
constexpr double furthest = -0.4226;

/// Discs on a grid over the whole valid picture. They are drawn in two pictures so that neighbours keep their distance.
Worst worst_marker(const TestCamera& camera, double radius_px) {
    const camera::CameraModel model = camera.model();
    const int step = static_cast<int>(4.0 * radius_px) + 20;
    Worst worst;
    for (const int odd : {0, 1}) {
        std::vector<Disc> discs;
        std::vector<glm::dvec2> exact;
        for (int row = 0; row * step + 16 < camera.size.height - 12; ++row) {
            for (int column = 0; column * step + 16 < camera.size.width - 12; ++column) {
                if ((row + column) % 2 != odd) continue;
                // Phases differ from disc to disc.
                const glm::dvec2 pixel(column * step + 16 + 0.37 * row, row * step + 16 + 0.29 * column);
                const auto disc = disc_at(model, pixel, 4.0, radius_px);
                if (!disc || model.ray(pixel)->z < furthest) continue;
                const glm::dvec2 steps = *ray_steps(model, pixel);
                if (std::max(steps.x, steps.y) > 3.0 * std::min(steps.x, steps.y)) continue;  // a sliver at the fold
                discs.push_back(*disc);
                exact.push_back(exact_centroid(model, *disc));
            }
        }
        const Picture picture = draw(world_of(discs), camera);
        for (const glm::dvec2 place : exact) {
            const double reach = radius_px + 6.0;
            if (place.x < reach || place.y < reach || place.x > camera.size.width - 1 - reach ||
                place.y > camera.size.height - 1 - reach) {
                continue;
            }
            const double error = glm::length(seen_centroid(picture, place, reach) - place);
            worst.error = std::max(worst.error, error);
            ++worst.seen;
        }
    }
    return worst;
}

TEST(LensMarkers, APinholeCameraShowsThemWithinTwoHundredthsOfAPixel) {
    const TestCamera camera{.size = picture_size,
                            .intrinsics = camera::Intrinsics{511.3, 507.9, 301.7, 245.2},
                            .antialias = world::Antialias::ssaa4};
    const Worst worst = worst_marker(camera, 16.0);
    std::printf("pinhole: %.4f px, %d markers\n", worst.error, worst.seen);
    EXPECT_GT(worst.seen, 25);
    EXPECT_LT(worst.error, 0.02);
}

TEST(LensMarkers, EveryLensShowsThemWithinFiveHundredthsOfAPixelByEveryMethod) {
    for (const LensCase& lens_case : lens_cases) {
        for (const world::LensMethod method :
             {world::LensMethod::automatic, world::LensMethod::warp, world::LensMethod::cube}) {
            const bool is_wide = lens_case.intrinsics.fx < 200;
            if (is_wide && method == world::LensMethod::warp) continue;  // no plane holds it
            const TestCamera camera{.size = picture_size,
                                    .intrinsics = lens_case.intrinsics,
                                    .lens = lens_case.lens,
                                    .lens_sampling = {.method = method},
                                    .antialias = world::Antialias::ssaa4};
            const Worst worst = worst_marker(camera, 7.0);
            std::printf("%s, %s: %.4f px, %d markers\n", lens_case.name, std::string(to_string(method)).c_str(),
                        worst.error, worst.seen);
            EXPECT_GT(worst.seen, 60) << lens_case.name;
            EXPECT_LT(worst.error, 0.05) << lens_case.name << ", " << to_string(method);
        }
    }
}

TEST(LensMarkers, FiltersAndSamplesMoveNothing) {
    const LensCase& lens_case = lens_cases[1];
    for (const world::Antialias antialias :
         {world::Antialias::none, world::Antialias::msaa4, world::Antialias::ssaa2}) {
        for (const world::LensFilter filter : {world::LensFilter::bilinear, world::LensFilter::bicubic}) {
            const TestCamera camera{.size = picture_size,
                                    .intrinsics = lens_case.intrinsics,
                                    .lens = lens_case.lens,
                                    .lens_sampling = {.filter = filter},
                                    .antialias = antialias};
            // One sample per texel places the outline of a disc of radius 7 within about 0.05 px (rms).
            const double bound = antialias == world::Antialias::none ? 0.2 : 0.1;
            const Worst worst = worst_marker(camera, 7.0);
            std::printf("%s, %s: %.4f px\n", std::string(to_string(antialias)).c_str(),
                        std::string(to_string(filter)).c_str(), worst.error);
            EXPECT_LT(worst.error, bound) << to_string(antialias) << ", " << to_string(filter);
        }
    }
}

}  // namespace
}  // namespace camrig::render
