#include "core/engine/cost_classes.h"

#include <random>

#include <gtest/gtest.h>

namespace camrig::engine::cost_classes_test {
namespace {

std::vector<TimeNs> ms(std::initializer_list<double> costs) {
    std::vector<TimeNs> made;
    for (const double cost : costs) made.push_back(static_cast<TimeNs>(cost * ns_per_ms));
    return made;
}
TimeNs ms(double cost) {
    return static_cast<TimeNs>(cost * ns_per_ms);
}
void divide(CostClasses& classes, std::initializer_list<double> costs) {
    auto all = ms(costs);
    classes.divide(all);
}

TEST(CostClasses, LieAFactorOfFourApartWhereNothingIsNear) {
    CostClasses classes;
    divide(classes, {1.0, 9.0, 30.0, 120.0, 900.0});
    EXPECT_EQ(classes.of(ms(1.0)), 0);
    EXPECT_EQ(classes.of(ms(9.0)), 1);
    EXPECT_EQ(classes.of(ms(30.0)), 2);
    EXPECT_EQ(classes.of(ms(120.0)), 3);
    EXPECT_EQ(classes.of(ms(900.0)), 4);
    EXPECT_EQ(classes.of(0), 0);
    EXPECT_EQ(classes.of(max_time_ns), 4);
}

TEST(CostClasses, NeverDivideWhatCostsAlike) {
    std::mt19937 random(1);
    for (int round = 0; round < 10'000; ++round) {
        CostClasses classes;
        // A few likes about one cost anywhere, beside others that come and go.
        const double about = std::exp(std::uniform_real_distribution(std::log(1.0), std::log(400.0))(random));
        for (int turn = 0; turn < 20; ++turn) {
            std::vector<TimeNs> costs;
            for (int i = 0; i < 8; ++i) costs.push_back(ms(about * std::uniform_real_distribution(1.0, 1.12)(random)));
            const std::vector<TimeNs> alike = costs;
            if (turn % 2 == 0) costs.push_back(ms(about * 6.0));
            classes.divide(costs);
            for (const TimeNs cost : alike) ASSERT_EQ(classes.of(cost), classes.of(alike.front())) << about;
        }
    }
}

TEST(CostClasses, StayWhereACostVaries) {
    CostClasses classes;
    divide(classes, {4.0});
    const int before = classes.of(ms(4.0));
    for (const double cost : {4.3, 3.75, 4.1, 3.9, 4.4, 3.7}) {
        divide(classes, {cost});
        EXPECT_EQ(classes.of(ms(cost)), before) << cost;
    }
}

TEST(CostClasses, KeepWhatIsDearApart) {
    CostClasses classes;
    divide(classes, {3.9, 4.1, 4.0, 6.5});
    EXPECT_EQ(classes.of(ms(3.9)), classes.of(ms(4.1)));
    EXPECT_LT(classes.of(ms(4.1)), classes.of(ms(6.5)));
    divide(classes, {15.0, 17.0, 70.0});
    EXPECT_EQ(classes.of(ms(15.0)), classes.of(ms(17.0)));
    EXPECT_LT(classes.of(ms(17.0)), classes.of(ms(70.0)));
}

}  // namespace
}  // namespace camrig::engine::cost_classes_test
