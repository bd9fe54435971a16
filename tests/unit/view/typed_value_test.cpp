#include "tools/view/typed_value.h"

#include <gtest/gtest.h>

namespace camrig::view {
namespace {

using nlohmann::json;

TEST(TypedValue, WhatIsShownIsWhatIsTypedAgain) {
    const json speed{{"type", "number or null"}, {"null", "as fast as it can"}};
    const json word{{"type", "number or \"auto\""}, {"word", "auto"}};
    const json limits{{"type", "array of numbers or null"}, {"null", "none"}};
    const json bits{{"type", "integer"}}, name{{"type", "string"}}, far{{"type", "array of numbers"}};
    const std::pair<json, json> cases[] = {{speed, nullptr}, {speed, 1.25},     {word, "auto"},
                                           {word, 0.001},    {limits, nullptr}, {limits, {-90, 20.5}},
                                           {bits, 12},       {name, "12"},      {far, json::array()}};
    for (const auto& [field, value] : cases) EXPECT_EQ(typed_value(field, text_of(value)), value) << field;
}

TEST(TypedValue, WhatIsNoNumberIsForTheRigToRefuse) {
    EXPECT_EQ(typed_value({{"type", "number"}}, "1,5"), "1,5");
    EXPECT_EQ(typed_value({{"type", "array of numbers"}}, " 1 x "), json({1, "x"}));
    EXPECT_EQ(typed_value({{"type", "number"}}, "true"), "true");
}

TEST(TypedValue, AnOutputToComeIsShownWithItsDefaults) {
    EXPECT_EQ(empty_value({{"type", "integer"}, {"default", "90"}, {"minimum", 1}}), 90);
    const json number = empty_value({{"type", "integer"}, {"minimum", 3.0}});
    EXPECT_TRUE(number.is_number_integer() && number == 3) << "what is whole is sent whole: " << number;
    EXPECT_EQ(empty_value({{"type", "string"}, {"choices", {"h264", "mjpeg"}}}), "h264");
    EXPECT_EQ(empty_value({{"type", "string"}, {"choices", {"a", "b"}}, {"default", "b"}}), "b");
}

}  // namespace
}  // namespace camrig::view
