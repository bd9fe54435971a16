#include "core/render/layer_table.h"

#include <gtest/gtest.h>

namespace camrig::render::software {
namespace {

using Table = LayerTable<int>;
constexpr std::int64_t layer_bytes = 100;
constexpr CameraId first{1}, second{2}, third{3};

StaticLayerKey key_of(std::uint64_t revision) {
    StaticLayerKey key;
    key.spec_revision = revision;
    return key;
}

/// As a renderer does it: asks, and keeps a layer where there is none yet and there is room.
bool keep(Table& table, CameraId camera, std::uint64_t revision = 1) {
    int* const layer = table.layer_of(camera, key_of(revision));
    if (layer == nullptr) return false;
    if (*layer != 0) return true;
    if (!table.make_room(layer_bytes)) return false;
    table.charge(*layer, layer_bytes);
    *layer = 1;
    return true;
}

void wait(Table& table, std::uint64_t instants) {
    for (std::uint64_t i = 0; i < instants; ++i) table.next_instant();
}

TEST(LayerTable, OnlyWhatIsSeenTwiceWithTheSameKeyHasOne) {
    Table table(1000);
    EXPECT_FALSE(keep(table, first));
    EXPECT_TRUE(keep(table, first));
    EXPECT_TRUE(keep(table, first));
    EXPECT_EQ(table.counters().layers, 1);
    EXPECT_EQ(table.counters().layer_bytes, layer_bytes);
    EXPECT_FALSE(keep(table, first, 2)) << "another key";
    EXPECT_EQ(table.counters().layers_stale, 1u);
    EXPECT_EQ(table.counters().layer_bytes, 0);
    EXPECT_TRUE(keep(table, first, 2));
}

TEST(LayerTable, EveryPartOfTheKeyCounts) {
    const StaticLayerKey key = key_of(1);
    StaticLayerKey moved = key, other_quality = key, other_statics = key;
    moved.pose.position.x = 1e-12;
    other_quality.quality = world::Quality::fast;
    other_statics.statics = 1;
    for (const StaticLayerKey& changed : {key_of(2), moved, other_quality, other_statics}) {
        Table table(1000);
        table.layer_of(first, key);
        ASSERT_NE(table.layer_of(first, key), nullptr);
        EXPECT_EQ(table.layer_of(first, changed), nullptr);
    }
}

TEST(LayerTable, WithoutMemoryThereIsNone) {
    Table table(0);
    for (int i = 0; i < 3; ++i) EXPECT_FALSE(keep(table, first));
}

TEST(LayerTable, OneInUseNeverMakesRoomTheOneLongestUnusedDoes) {
    Table table(2 * layer_bytes);
    for (int i = 0; i < 2; ++i) {
        table.next_instant();
        for (const CameraId camera : {first, second, third}) keep(table, camera);
    }
    EXPECT_EQ(table.counters().layers, 2) << "no room for the third";
    EXPECT_EQ(table.counters().layers_evicted, 0u);
    // Neither of them for a while, the first longer than the second.
    table.next_instant();
    keep(table, second);
    wait(table, Table::kept_instants);
    EXPECT_TRUE(keep(table, third));
    EXPECT_EQ(table.counters().layers_evicted, 1u);
    EXPECT_EQ(*table.layer_of(second, key_of(1)), 1) << "used later";
    EXPECT_EQ(*table.layer_of(first, key_of(1)), 0) << "its place is there, to be filled again";
    EXPECT_LE(table.counters().layer_bytes, 2 * layer_bytes);
}

TEST(LayerTable, WhatIsForgottenGivesItsMemoryBack) {
    Table table(layer_bytes);
    for (int i = 0; i < 2; ++i) keep(table, first);
    table.forget(first);
    table.forget(second);
    EXPECT_EQ(table.counters().layer_bytes, 0);
    EXPECT_FALSE(keep(table, first)) << "as a new one";
    EXPECT_TRUE(keep(table, first));
}

}  // namespace
}  // namespace camrig::render::software
