#include "core/truth/silhouettes.h"

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace camrig::truth {
namespace {

bool touch(const PixelBox& a, const PixelBox& b) {
    for (int y = a.y; y < a.y + a.height; ++y) {
        for (int x = a.x; x < a.x + a.width; ++x) {
            if (x >= b.x && x < b.x + b.width && y >= b.y && y < b.y + b.height) return true;
        }
    }
    return false;
}

TEST(GroupApart, BoxesOfOneGroupNeverTouch) {
    std::uint64_t n = 0;
    const auto below = [&](int end) { return static_cast<int>(random_unit(3, 1, n++) * end); };
    std::vector<PixelBox> boxes;
    for (int i = 0; i < 60; ++i) boxes.push_back({below(90), below(90), 1 + below(20), 1 + below(20)});
    const auto groups = group_apart(boxes);
    ASSERT_EQ(groups.size(), boxes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            EXPECT_FALSE(groups[i] == groups[j] && touch(boxes[i], boxes[j])) << i << " " << j;
        }
    }
}

TEST(GroupApart, NeighboursShareAGroup) {
    const std::vector<PixelBox> side_by_side{{0, 0, 10, 10}, {10, 0, 10, 10}, {0, 10, 20, 5}};
    EXPECT_EQ(group_apart(side_by_side), (std::vector<std::size_t>{0, 0, 0}));
    EXPECT_TRUE(group_apart({}).empty());
}

}  // namespace
}  // namespace camrig::truth
