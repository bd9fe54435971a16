#include "core/camera/lens.h"

#include <gtest/gtest.h>

namespace camrig::camera::lens_test {
namespace {

TEST(LensModels, HaveTheNamesAndCoefficientCountsOfRos) {
    const struct {
        LensModel model;
        std::string_view name;
        int count;
    } expected[] = {{LensModel::pinhole, "pinhole", 0},
                    {LensModel::plumb_bob, "plumb_bob", 5},
                    {LensModel::rational_polynomial, "rational_polynomial", 8},
                    {LensModel::equidistant, "equidistant", 4}};
    for (const auto& [model, name, count] : expected) {
        EXPECT_EQ(to_string(model), name);
        EXPECT_EQ(coefficient_count(model), count);
        const auto parsed = parse_name<LensModel>(name);
        ASSERT_TRUE(parsed);
        EXPECT_EQ(*parsed, model);
    }
}

TEST(LensModels, AnUnknownNameIsRefusedWithTheKnownOnes) {
    for (const std::string_view name : {"", "Pinhole", "plumb_bob ", "fisheye", "radtan"}) {
        const auto parsed = parse_name<LensModel>(name);
        ASSERT_FALSE(parsed) << name;
        EXPECT_EQ(parsed.error().kind, ErrorKind::invalid_argument);
        EXPECT_NE(parsed.error().message.find("plumb_bob"), std::string::npos);
    }
    const auto long_name = parse_name<LensModel>(std::string(1 << 20, 'x'));
    ASSERT_FALSE(long_name);
    EXPECT_LT(long_name.error().message.size(), 200u);
}

TEST(Lens, DefaultIsAPinholeWithoutCoefficients) {
    const Lens lens;
    EXPECT_EQ(lens.model, LensModel::pinhole);
    for (const double k : lens.coefficients) EXPECT_EQ(k, 0.0);
}

}  // namespace
}  // namespace camrig::camera::lens_test
