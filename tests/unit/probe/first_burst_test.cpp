#include "tools/probe/first_burst.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace camrig::probe {
namespace {

constexpr TimeNs taken_every_ns = 40 * ns_per_ms;

struct Picture {
    TimeNs arrival_ns = 0, stamp_ns = 0;
};

/// Taken 25 times a second from time 0; until `open_ns` they pile up, then they come 1 ms apart, then as they are
/// taken.
std::vector<Picture> opened_late(TimeNs open_ns, int count) {
    std::vector<Picture> pictures;
    TimeNs free_ns = open_ns;
    for (int n = 0; n < count; ++n) {
        free_ns = std::max(free_ns + ns_per_ms, n * taken_every_ns);
        pictures.push_back({free_ns, n * taken_every_ns});
    }
    return pictures;
}

TEST(FirstBurst, PicturesThatPiledUpAreNotCounted) {
    for (const TimeNs open_ns : {0 * taken_every_ns, 5 * taken_every_ns, 12 * taken_every_ns + ns_per_ms,
                                 12 * taken_every_ns + 39 * ns_per_ms}) {
        FirstBurst burst;
        std::vector<Picture> counted;
        for (const Picture& picture : opened_late(open_ns, 100))
            if (burst.is_over(picture.arrival_ns, picture.stamp_ns)) counted.push_back(picture);
        counted.erase(counted.begin());  // it ends the burst, and measuring begins after it
        ASSERT_GE(counted.size(), 80u);
        const double seconds = static_cast<double>(counted.back().arrival_ns - counted.front().arrival_ns) / ns_per_s;
        EXPECT_DOUBLE_EQ(static_cast<double>(counted.size() - 1) / seconds, 25);
    }
}

TEST(FirstBurst, ASourceWithoutStampsIsCountedFromItsFirstPicture) {
    FirstBurst burst;
    EXPECT_TRUE(burst.is_over(5, std::nullopt));
}

TEST(FirstBurst, ASourceThatAlwaysComesTooFastIsCountedAfterTwoSeconds) {
    FirstBurst burst;
    TimeNs now_ns = 0;
    while (!burst.is_over(now_ns, 10 * now_ns)) now_ns += ns_per_ms;
    EXPECT_EQ(now_ns, FirstBurst::max_ns + ns_per_ms);
}

}  // namespace
}  // namespace camrig::probe
