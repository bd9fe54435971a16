#include "tools/view/timeline.h"

#include <gtest/gtest.h>

namespace camrig::view {
namespace {

constexpr std::int64_t second = 1'000'000'000;

RigModel at(std::int64_t world_ns, std::vector<ActorRow> actors) {
    RigModel model;
    model.world.world_ns = world_ns;
    model.actors = std::move(actors);
    return model;
}

TEST(Timeline, ADoingLastsUntilTheNext) {
    Timeline timeline;
    timeline.update(at(1 * second, {{"anna", "walk"}}));
    timeline.update(at(3 * second, {{"anna", "walk"}}));
    timeline.update(at(4 * second, {{"anna", "talk"}}));
    const auto& doings = timeline.actors().at("anna");
    ASSERT_EQ(doings.size(), 2u);
    EXPECT_EQ(doings[0].from_ns, 1 * second);
    EXPECT_EQ(doings[0].to_ns, 3 * second);
    EXPECT_EQ(doings[1].from_ns, 3 * second);
    EXPECT_EQ(doings[1].to_ns, 4 * second);
}

TEST(Timeline, ForgetsWhatIsLongAgoAndBeginsAnewInAnotherWorld) {
    Timeline timeline;
    timeline.update(at(1 * second, {{"anna", "walk"}, {"ben", "talk"}}));
    timeline.update(at(100 * second, {{"ben", "talk"}}));
    EXPECT_FALSE(timeline.actors().contains("anna"));
    EXPECT_TRUE(timeline.actors().contains("ben"));
    timeline.update(at(0, {}));
    EXPECT_TRUE(timeline.actors().empty());
}

}  // namespace
}  // namespace camrig::view
