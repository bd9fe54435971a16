#include "core/frame/frame_pool.h"

#include <thread>

#include <gtest/gtest.h>

#include "tests/unit/frame/test_pictures.h"

namespace camrig::frame {
namespace {

using test::frame_info;

TEST(FramePool, ABufferThatComesBackIsUsedAgain) {
    FramePool pool;
    auto first = pool.acquire(frame_info({64, 48}));
    const std::byte* const memory = first->bytes().data();
    EXPECT_EQ(first->bytes().size(), 64U * 48 * 4);
    first.reset();
    EXPECT_EQ(pool.idle_bytes(), 64U * 48 * 4);

    FrameInfo info = frame_info({48, 64});
    info.sequence = 43;
    const auto second = pool.acquire(info);
    EXPECT_EQ(second->bytes().data(), memory);
    EXPECT_EQ(second->info().sequence, 43);
    EXPECT_EQ(second->info().size, (ImageSize{48, 64}));
    EXPECT_EQ(pool.idle_bytes(), 0U);
}

TEST(FramePool, FramesInUseAreNeverShared) {
    FramePool pool;
    const auto a = pool.acquire(frame_info({16, 16}));
    const auto b = pool.acquire(frame_info({16, 16}));
    EXPECT_NE(a->bytes().data(), b->bytes().data());
}

TEST(FramePool, KeepsNoMoreThanItsBoundAndDropsTheOldest) {
    const std::size_t one = bytes_of(PixelFormat::rgba8, {16, 16});
    FramePool pool(2 * one);
    auto a = pool.acquire(frame_info({16, 16}));
    auto b = pool.acquire(frame_info({16, 16}));
    auto c = pool.acquire(frame_info({16, 16}));
    const std::byte* const newest = c->bytes().data();
    a.reset();
    b.reset();
    c.reset();
    EXPECT_EQ(pool.idle_bytes(), 2 * one);
    EXPECT_EQ(pool.acquire(frame_info({16, 16}))->bytes().data(), newest);

    auto large = pool.acquire(frame_info({64, 64}));
    large.reset();
    EXPECT_LE(pool.idle_bytes(), 2 * one) << "a buffer over the bound is freed at once";
}

TEST(FramePool, GivesBackWhatNobodyUses) {
    FramePool pool;
    const auto used = pool.acquire(frame_info({16, 16}));
    pool.acquire(frame_info({64, 64})).reset();
    EXPECT_GT(pool.idle_bytes(), 0U);
    pool.release_idle();
    EXPECT_EQ(pool.idle_bytes(), 0U);
    EXPECT_EQ(used->bytes().size(), 16U * 16 * 4) << "what is in use stays";
}

TEST(FramePool, WhatIsMarkedGoesBackToItsCameraAndKind) {
    FramePool pool;
    const auto of_camera = [&](std::uint32_t camera, FrameKind kind = FrameKind::color) {
        FrameInfo info = frame_info({16, 16});
        info.camera_id = CameraId(camera);
        info.kind = kind;
        return pool.acquire(info);
    };
    auto own = of_camera(1), other = of_camera(2), plain = of_camera(1);
    EXPECT_EQ(own->held_before(), 0U) << "new memory";
    own->mark_content(71);
    other->mark_content(72);
    const std::byte *const own_memory = own->bytes().data(), *const other_memory = other->bytes().data();
    const std::byte* const plain_memory = plain->bytes().data();
    plain.reset();
    own.reset();
    other.reset();  // the newest

    const auto depth = of_camera(1, FrameKind::depth);
    EXPECT_EQ(depth->bytes().data(), plain_memory) << "other kinds leave what is marked";
    own = of_camera(1);
    EXPECT_EQ(own->bytes().data(), own_memory);
    EXPECT_EQ(own->held_before(), 71U);
    EXPECT_EQ(own->content_mark(), 0U) << "what is written next has no mark yet";
    own.reset();
    own = of_camera(1);
    EXPECT_EQ(own->bytes().data(), own_memory);
    EXPECT_EQ(own->held_before(), 0U) << "somebody wrote there";
    const auto third = of_camera(3);
    EXPECT_EQ(third->bytes().data(), other_memory) << "rather than new memory";
    EXPECT_EQ(third->held_before(), 72U);
}

TEST(FramePool, FramesMayOutliveThePool) {
    FrameRef survivor;
    {
        FramePool pool;
        survivor = pool.acquire(frame_info({16, 16}));
    }
    EXPECT_EQ(survivor->bytes().size(), 1024U);
    survivor.reset();
}

TEST(FramePool, ManyThreadsTakeAndGiveBack) {
    FramePool pool;
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t) {
        threads.emplace_back([&, t] {
            for (int i = 0; i < 500; ++i) {
                auto frame = pool.acquire(frame_info({16 + 16 * (i % 3), 16}));
                const auto mark = static_cast<std::byte>(t);
                for (std::byte& b : frame->mutable_bytes()) b = mark;
                for (const std::byte b : frame->bytes()) ASSERT_EQ(b, mark);
            }
        });
    }
    threads.clear();
    EXPECT_LE(pool.idle_bytes(), 4U * 3 * 48 * 16 * 4);
}

}  // namespace
}  // namespace camrig::frame
