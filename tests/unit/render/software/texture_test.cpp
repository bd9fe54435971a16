#include "core/render/software/texture.h"

#include <cmath>

#include <gtest/gtest.h>

namespace camrig::render::software {
namespace {

double linear_of(int code) {
    const double value = code / 255.0;
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

TEST(SoftwareImage, ColourIsLinearLightAlphaAndDataAreNot) {
    world::Image ramp{.size = {256, 1}, .rgba = {}};
    for (int i = 0; i < 256; ++i) ramp.rgba.insert(ramp.rgba.end(), 4, static_cast<std::uint8_t>(i));
    const SoftwareImage color = make_software_image(ramp, true), data = make_software_image(ramp, false);
    for (std::size_t i = 0; i < 256; ++i) {
        const Texel &c = color.texels[i], &d = data.texels[i];
        const int code = static_cast<int>(i);
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_NEAR(c[k], 65535.0 * linear_of(code), 0.5 + 1e-9);
            EXPECT_EQ(d[k], 257 * code);
        }
        EXPECT_EQ(c[3], 257 * code);
    }
}

TEST(SoftwareImage, LevelsAreHalvesDownToOneTexel) {
    const world::Image image{.size = {37, 5}, .rgba = std::vector<std::uint8_t>(37 * 5 * 4, 90)};
    const SoftwareImage made = make_software_image(image, true);
    std::vector<std::pair<int, int>> sizes;
    std::size_t texels = 0;
    for (const SoftwareImage::Level& level : made.levels) {
        sizes.emplace_back(level.width, level.height);
        EXPECT_EQ(static_cast<std::size_t>(level.first), texels);
        texels += static_cast<std::size_t>(level.width * level.height);
    }
    EXPECT_EQ(made.texels.size(), texels);
    for (const Texel& texel : made.texels) EXPECT_EQ(texel, made.texels[0]) << "what is even stays so";
    const std::vector<std::pair<int, int>> expected{{37, 5}, {18, 2}, {9, 1}, {4, 1}, {2, 1}, {1, 1}};
    EXPECT_EQ(sizes, expected);
}

TEST(SoftwareImage, ATexelOfALevelIsTheMeanLightOfTheFourBelow) {
    const world::Image image{.size = {2, 2},
                             .rgba = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 0}};
    const Texel mean = make_software_image(image, true).texels_of(1)[0];
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(mean[k], 65535 / 2.0, 1.0);
    EXPECT_NEAR(mean[3], 65535 * 0.75, 1.0);
}

}  // namespace
}  // namespace camrig::render::software
