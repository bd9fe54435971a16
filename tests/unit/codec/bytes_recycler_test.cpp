#include "core/codec/bytes_recycler.h"

#include <gtest/gtest.h>

namespace camrig::codec {
namespace {

TEST(BytesRecycler, MemoryComesBackEmptyWithItsCapacity) {
    BytesRecycler recycler;
    auto first = recycler.acquire();
    first->resize(1000);
    const std::byte* const memory = first->data();
    first.reset();
    const auto second = recycler.acquire();
    EXPECT_TRUE(second->empty());
    second->resize(1000);
    EXPECT_EQ(second->data(), memory);
}

TEST(BytesRecycler, WhatItHandedOutMayOutliveIt) {
    auto bytes = BytesRecycler().acquire();
    bytes->assign({std::byte{1}, std::byte{2}});
    EXPECT_EQ(bytes->size(), 2U);
    EXPECT_EQ((*bytes)[1], std::byte{2});
}

}  // namespace
}  // namespace camrig::codec
