#include "core/base/tile_set.h"

#include <random>

#include <gtest/gtest.h>

namespace camrig {
namespace {

int pixels_of(const TileSet& tiles, ImageSize size) {
    int count = 0;
    for (int y = 0; y < size.height; ++y) {
        int last = 0;
        tiles.each_run(y, [&](int x0, int x1) {
            EXPECT_LE(last, x0);
            EXPECT_LT(x0, x1);
            EXPECT_LE(x1, size.width);
            last = x1;
            count += x1 - x0;
        });
    }
    return count;
}

TEST(TileSet, MarksWhatARectangleTouchesAndAddsItOnce) {
    TileSet tiles;
    tiles.clear({100, 40});
    std::vector<PixelRect> added;
    tiles.mark({15, 0, 17, 16}, added);
    EXPECT_EQ(added, (std::vector<PixelRect>{{0, 0, 32, 16}}));
    added.clear();
    tiles.mark({0, 3, 100, 40}, added);
    EXPECT_EQ(added, (std::vector<PixelRect>{{32, 0, 100, 16}, {0, 16, 100, 32}, {0, 32, 100, 40}}));
    tiles.mark({5, 5, 5, 30}, added);
    EXPECT_EQ(added.size(), 3u);
    EXPECT_EQ(pixels_of(tiles, {100, 40}), 4000);
}

/// In pictures of more than one word of tiles a row.
TEST(TileSet, WhatWasAddedIsWhatItsRunsHave) {
    constexpr ImageSize size{2300, 70};
    std::mt19937 random(3);
    const auto below = [&](int end) { return static_cast<int>(random() % static_cast<unsigned>(end)); };
    for (int turn = 0; turn < 50; ++turn) {
        TileSet tiles;
        tiles.clear(size);
        std::vector<PixelRect> added;
        for (int i = 0; i < 6; ++i) {
            const int x = below(size.width), y = below(size.height);
            tiles.mark({x, y, x + 1 + below(size.width - x), y + 1 + below(size.height - y)}, added);
        }
        std::int64_t area = 0;
        for (const PixelRect& rect : added) area += rect.area();
        ASSERT_EQ(pixels_of(tiles, size), area);
    }
}

}  // namespace
}  // namespace camrig
