#include "core/frame/tone.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/frame/test_pictures.h"

namespace camrig::frame {
namespace {

using Color = std::array<int, 3>;

Color toned(Color color, const ImageControls& controls) {
    std::array<std::byte, 4> pixel{static_cast<std::byte>(color[0]), static_cast<std::byte>(color[1]),
                                   static_cast<std::byte>(color[2]), std::byte{200}};
    apply_tone(pixel, controls);
    EXPECT_EQ(pixel[3], std::byte{200});
    return {std::to_integer<int>(pixel[0]), std::to_integer<int>(pixel[1]), std::to_integer<int>(pixel[2])};
}

ImageControls exposed(double ev) {
    return {.auto_exposure = false, .exposure_ev = ev};
}

TEST(Tone, TheControlsOneHasAtTheStartChangeNothing) {
    EXPECT_TRUE(changes_nothing({}));
    EXPECT_TRUE(changes_nothing({.exposure_ev = 3, .white_balance_k = 3000}));  // overridden by the automatics
    Frame picture = test::noise({64, 48});
    const std::vector<std::byte> before(picture.bytes().begin(), picture.bytes().end());
    apply_tone(picture.mutable_bytes(), {});
    EXPECT_TRUE(std::ranges::equal(picture.bytes(), before));
}

// Twice the light is 2.2 times the linear value under the sRGB curve: 128 is 0.2159, and 0.4317 is 175.3.
TEST(Tone, AStopOfExposureIsTwiceTheLight) {
    EXPECT_EQ(toned({128, 128, 128}, exposed(1)), (Color{176, 176, 176}));
    EXPECT_EQ(toned({176, 176, 176}, exposed(-1)), (Color{128, 128, 128}));
    EXPECT_EQ(toned({0, 255, 200}, exposed(2)), (Color{0, 255, 255}));
    EXPECT_EQ(toned({128, 128, 128}, {.gain_db = 20 * std::log10(2)}), (Color{176, 176, 176}));
}

TEST(Tone, BrightnessAndContrastActOnCodes) {
    EXPECT_EQ(toned({100, 0, 250}, {.brightness = 0.2}), (Color{151, 51, 255}));
    EXPECT_EQ(toned({100, 0, 250}, {.brightness = -0.2}), (Color{49, 0, 199}));
    EXPECT_EQ(toned({100, 0, 255}, {.contrast = 0.5}), (Color{114, 64, 191}));
    EXPECT_EQ(toned({17, 99, 255}, {.contrast = 0}), (Color{128, 128, 128}));
}

TEST(Tone, WithoutSaturationAPictureIsGrey) {
    const Color grey = toned({200, 100, 50}, {.saturation = 0});
    EXPECT_EQ(grey, (Color{124, 124, 124}));  // 0.299 R + 0.587 G + 0.114 B
    EXPECT_EQ(toned({200, 100, 50}, {.saturation = 2}), (Color{255, 76, 0}));
    EXPECT_EQ(toned({90, 90, 90}, {.saturation = 2}), (Color{90, 90, 90}));
}

TEST(Tone, TakingWarmLightForWhiteMakesThePictureBlue) {
    const auto balanced = [](double kelvin) {
        return toned({128, 128, 128}, {.auto_white_balance = false, .white_balance_k = kelvin});
    };
    EXPECT_EQ(balanced(6500), (Color{128, 128, 128}));
    const Color warm_light = balanced(3000), cold_light = balanced(10000);
    EXPECT_LT(warm_light[0], 110);
    EXPECT_EQ(warm_light[1], 128);
    EXPECT_GT(warm_light[2], 190);
    EXPECT_GT(cold_light[0], 128);
    EXPECT_LT(cold_light[2], 120);
}

TEST(Tone, GreyStaysInOrderUnderEveryControl) {
    for (const ImageControls& controls :
         {exposed(-3), exposed(3), ImageControls{.gain_db = 12}, ImageControls{.contrast = 1.7},
          ImageControls{.auto_white_balance = false, .white_balance_k = 2800}, ImageControls{.brightness = -0.4}}) {
        Color before{-1, -1, -1};
        for (int code = 0; code < 256; ++code) {
            const Color now = toned({code, code, code}, controls);
            for (std::size_t i = 0; i < 3; ++i) EXPECT_GE(now[i], before[i]);
            before = now;
        }
    }
}

}  // namespace
}  // namespace camrig::frame
