#include "core/base/thread_check.h"

#include <thread>

#include <gtest/gtest.h>

namespace camrig {
namespace {

TEST(ThreadCheck, TheFirstThreadThatAsksOwnsItAndAnyOtherIsABug) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    ThreadCheck mine, another;
    mine.check();
    mine.check();
    std::thread([&] { another.check(); }).join();
    EXPECT_DEATH(std::thread([&] { mine.check(); }).join(), "thread_check.h");
    EXPECT_DEATH(another.check(), "thread_check.h");
}

}  // namespace
}  // namespace camrig
