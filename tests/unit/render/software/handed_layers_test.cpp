#include "core/render/software/handed_layers.h"

#include <gtest/gtest.h>

namespace camrig::render::software {
namespace {

HandedLayers::Handed layer(std::int64_t bytes) {
    HandedLayers::Handed handed;
    handed.kept.bytes = bytes;
    return handed;
}

TEST(HandedLayers, TakeTheRoomOfWhatWaitsAndOfNothingElse) {
    constexpr CameraId camera{1}, other{2};
    const int giver = 0, taker = 0;
    HandedLayers layers;
    for (int i = 0; i < 10; ++i) layers.put(camera, &giver, layer(30), 100);  // each takes the place of the one before
    layers.put(other, &giver, layer(80), 100);
    EXPECT_FALSE(layers.take(other, &taker)) << "there is no room for both";
    layers.put(other, &giver, layer(70), 100);
    EXPECT_TRUE(layers.take(other, &taker));
    EXPECT_FALSE(layers.take(camera, &giver)) << "who gave it does not take it back";
    EXPECT_TRUE(layers.take(camera, &taker));
    EXPECT_FALSE(layers.take(camera, &taker));
    layers.put(camera, &giver, layer(100), 100);
    layers.forget(camera);
    layers.put(other, &giver, layer(100), 100);
    EXPECT_TRUE(layers.take(other, &taker));
}

}  // namespace
}  // namespace camrig::render::software
