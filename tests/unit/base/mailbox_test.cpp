#include "core/base/mailbox.h"

#include <gtest/gtest.h>

namespace camrig {
namespace {

TEST(Mailbox, TheNewestWinsAndTheReplacedOneComesBack) {
    Mailbox<int> box;
    EXPECT_FALSE(box.put(1).has_value());
    EXPECT_EQ(box.put(2), 1);
    EXPECT_EQ(box.take(), 2);
    EXPECT_FALSE(box.take().has_value());
}

}  // namespace
}  // namespace camrig
