#include "core/render/scene/lens_view.h"

#include <gtest/gtest.h>

#include "core/camera/lens_map.h"

namespace camrig::render::scene {
namespace {

struct HardLens {
    const char* what;
    ImageSize size;
    double focal_px;
    glm::dvec2 centre;  ///< of the picture's width and height
    camera::LensModel model;
    std::vector<double> coefficients;
};

const HardLens hard_lenses[] = {
    {"a barrel that folds within the picture",
     {160, 120},
     50.0,
     {0.5, 0.5},
     camera::LensModel::plumb_bob,
     {-0.3, 0.0, 0.0, 0.0, 0.0}},
    {"the same, with tangential terms",
     {160, 120},
     50.0,
     {0.5, 0.5},
     camera::LensModel::plumb_bob,
     {-0.3, 0.02, 0.01, -0.02, 0.0}},
    {"strong tangential terms, aside",
     {161, 97},
     40.0,
     {0.2, 0.9},
     camera::LensModel::plumb_bob,
     {-0.2, 0.0, -0.06, 0.05, 0.0}},
    {"tangential terms alone", {120, 90}, 30.0, {0.6, 0.4}, camera::LensModel::plumb_bob, {0.0, 0.0, 0.08, 0.03, 0.0}},
    {"a rim that crosses only a corner",
     {200, 150},
     300.0,
     {-0.6, -0.5},
     camera::LensModel::plumb_bob,
     {-0.3, 0.0, 0.004, 0.002, 0.0}},
    {"a rim of a few pixels", {64, 48}, 4.0, {0.5, 0.5}, camera::LensModel::plumb_bob, {-0.3, 0.0, 0.02, 0.01, 0.0}},
    {"a rim smaller than a pixel",
     {33, 21},
     0.4,
     {0.47, 0.51},
     camera::LensModel::plumb_bob,
     {-0.3, 0.0, 0.01, 0.0, 0.0}},
    {"a rational one with tangential terms",
     {150, 110},
     40.0,
     {0.5, 0.55},
     camera::LensModel::rational_polynomial,
     {-0.4, 0.1, 0.01, 0.02, 0.01, 0.1, 0.05, 0.01}},
    {"a rational one that ends",
     {150, 110},
     30.0,
     {0.5, 0.5},
     camera::LensModel::rational_polynomial,
     {0.1, 0.0, 0.0, 0.0, 0.0, 0.5, 0.1, 0.0}},
    {"a fisheye of 360 degrees", {128, 128}, 15.0, {0.5, 0.5}, camera::LensModel::equidistant, {0.0, 0.0, 0.0, 0.0}},
    {"a fisheye that folds", {128, 100}, 40.0, {0.45, 0.5}, camera::LensModel::equidistant, {-0.1, 0.0, 0.0, 0.0}},
};

// Which pixels see nothing is looked for along the rim of the lens alone.
TEST(LensView, BlindPixelsAreThoseThatHaveNoRay) {
    for (const HardLens& hard : hard_lenses) {
        const auto [width, height] = hard.size;
        for (const double stretch : {1.0, 1.37}) {
            const camera::Intrinsics intrinsics{hard.focal_px, stretch * hard.focal_px, hard.centre.x * (width - 1),
                                                hard.centre.y * (height - 1)};
            const auto lens = camera::make_lens(hard.model, hard.coefficients);
            ASSERT_TRUE(lens) << hard.what;
            const auto view = LensView::create(hard.size, intrinsics, *lens);
            ASSERT_TRUE(view) << hard.what;
            std::vector<bool> blind(static_cast<std::size_t>(hard.size.pixels()));
            std::pair last(-1, 0);
            for (const auto& [y, x0, x1] : (*view)->blind()) {
                EXPECT_LT(last, std::pair(y, x0)) << hard.what << ": by rows";
                last = {y, x1};
                for (int x = x0; x < x1; ++x) blind[static_cast<std::size_t>(y * width + x)] = true;
            }
            int wrong = 0, dark = 0;
            for (int y = 0; y < height; ++y) {
                for (int x = 0; x < width; ++x) {
                    const bool sees = (*view)->model().ray({x, y}).has_value();
                    wrong += sees == blind[static_cast<std::size_t>(y * width + x)];
                    dark += !sees;
                }
            }
            EXPECT_EQ(wrong, 0) << hard.what;
            EXPECT_GT(dark, 0) << hard.what << ": does not show what it is to show";
        }
    }
}

}  // namespace
}  // namespace camrig::render::scene
