#include "core/truth/id_census.h"

#include <vector>

#include <gtest/gtest.h>

namespace camrig::truth {
namespace {

using Ids = std::vector<std::uint32_t>;

TEST(IdCensus, CountsPixelsAndTheRectangleAroundThem) {
    const Ids ids{0, 7, 7, 0,  //
                  5, 0, 7, 0,  //
                  7, 0, 0, 5};
    const auto counts = count_ids(ids, {4, 3});
    ASSERT_EQ(counts.size(), 2u);
    EXPECT_EQ(counts.at(7).pixels, 4);
    EXPECT_EQ(counts.at(7).box, (PixelBox{0, 0, 3, 3}));
    EXPECT_EQ(counts.at(5).pixels, 2);
    EXPECT_EQ(counts.at(5).box, (PixelBox{0, 1, 4, 2}));
}

TEST(IdCensus, RunsEndAtTheEndOfARow) {
    const Ids ids{0, 9,  //
                  9, 0};
    EXPECT_EQ(count_ids(ids, {2, 2}).at(9).box, (PixelBox{0, 0, 2, 2}));
    const Ids one(6, 3);
    EXPECT_EQ(count_ids(one, {2, 3}).at(3).box, (PixelBox{0, 0, 2, 3}));
}

TEST(IdCensus, NothingIsNoObject) {
    EXPECT_TRUE(count_ids(Ids(12, 0), {4, 3}).empty());
}

TEST(IdCensus, TheMainOccluderCoversMostOfWhatIsHidden) {
    const Ids alone{4, 4, 4, 4, 4, 4, 0, 0};
    const Ids scene{4, 8, 2, 2, 0, 8, 9, 9};
    const frame::Silhouette all = silhouette_of(alone, 4, {0, 0, 8, 1}, {8, 1});
    EXPECT_EQ(all, (frame::Silhouette{{0, 0, 6}}));
    EXPECT_EQ(main_occluder(scene, all, 4, {8, 1}), 2u);  // of equals the smaller
    EXPECT_EQ(main_occluder(scene, silhouette_of(alone, 4, {0, 0, 2, 1}, {8, 1}), 4, {8, 1}), 8u);
    EXPECT_EQ(main_occluder(alone, all, 4, {8, 1}), 0u);
}

TEST(IdCensus, TheMainOccluderIsFoundWhicheverOfManyItIs) {
    const std::vector<std::uint32_t> others{7, 30, 2, 19, 5, 11};
    for (const std::uint32_t most : others) {
        for (const std::uint32_t equal : others) {
            Ids scene;
            for (std::size_t i = 0; i < others.size(); ++i)
                scene.insert(scene.end(), others[i] == most || others[i] == equal ? 10 : i + 1, others[i]);
            const ImageSize size{static_cast<int>(scene.size()), 1};
            EXPECT_EQ(main_occluder(scene, {{0, 0, size.width}}, 4, size), std::min(most, equal));
        }
    }
}

TEST(IdCensus, ASilhouetteIsTheRunsOfEachRowInItsBox) {
    const Ids ids{4, 4, 0, 4,  //
                  0, 4, 4, 4,  //
                  4, 0, 0, 0};
    EXPECT_EQ(silhouette_of(ids, 4, {0, 0, 4, 3}, {4, 3}),
              (frame::Silhouette{{0, 0, 2}, {0, 3, 4}, {1, 1, 4}, {2, 0, 1}}));
    EXPECT_EQ(silhouette_of(ids, 4, {1, 0, 2, 2}, {4, 3}), (frame::Silhouette{{0, 1, 2}, {1, 1, 3}}));
    EXPECT_TRUE(silhouette_of(ids, 5, {0, 0, 4, 3}, {4, 3}).empty());
}

}  // namespace
}  // namespace camrig::truth
