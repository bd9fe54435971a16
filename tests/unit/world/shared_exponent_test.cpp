#include "core/world/baked/shared_exponent.h"

#include <cmath>
#include <random>

#include <glm/gtc/packing.hpp>
#include <gtest/gtest.h>

namespace camrig::world {
namespace {

TEST(SharedExponent, HasTheBitsOfGlm) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> doublings(-30.0f, 14.9f);
    for (int i = 0; i < 300000; ++i) {
        const glm::vec3 light(std::exp2(doublings(random)), std::exp2(doublings(random)), std::exp2(doublings(random)));
        ASSERT_EQ(packed_light(light), glm::packF3x9_E1x5(light)) << light.r << " " << light.g << " " << light.b;
    }
    for (int i = 0; i < 100000; ++i) {
        const auto packed = static_cast<std::uint32_t>(random());
        ASSERT_EQ(unpacked_light(packed), glm::unpackF3x9_E1x5(packed)) << packed;
    }
}

TEST(SharedExponent, KeepsZeroAndBothSidesOfEachPowerOfTwo) {
    EXPECT_EQ(unpacked_light(packed_light(glm::vec3(0.0f))), glm::vec3(0.0f));
    for (int doubling = -23; doubling <= 15; ++doubling) {
        const float power = std::ldexp(1.0f, doubling);
        EXPECT_EQ(unpacked_light(packed_light({power, 0.0f, power})), glm::vec3(power, 0.0f, power)) << doubling;
        const float below = std::nextafter(power, 0.0f);
        EXPECT_EQ(unpacked_light(packed_light(glm::vec3(below))), glm::vec3(power)) << doubling;
    }
}

TEST(SharedExponent, CutsWhatItCannotTell) {
    EXPECT_EQ(unpacked_light(packed_light({-1.0f, 1e30f, 65409.0f})), glm::vec3(0.0f, 65408.0f, 65408.0f));
}

}  // namespace
}  // namespace camrig::world
