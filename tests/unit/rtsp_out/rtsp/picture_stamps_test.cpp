#include "rtsp_out/rtsp/picture_stamps.h"

#include <random>

#include <gtest/gtest.h>

namespace camrig::rtsp {
namespace {

constexpr TimeNs begin_ns = 100 * ns_per_s;
constexpr TimeNs frame_ns = 40 * ns_per_ms;

/// Time in milliseconds after the stream's begin.
constexpr TimeNs at_ms(std::int64_t ms) {
    return begin_ns + ms * ns_per_ms;
}

class PictureStampsTest : public testing::Test {
protected:
    /// The regular work of the server, ten times a second up to this time: how often the last picture was sent again.
    int repeats_until(std::int64_t ms) { return repeats_until(ms, stamps); }
    int repeats_until(std::int64_t ms, PictureStamps& of) {
        int repeats = 0;
        for (now_ms_ += 100; now_ms_ <= ms; now_ms_ += 100)
            if (of.of_repeat(at_ms(now_ms_))) ++repeats;
        now_ms_ = ms;
        return repeats;
    }
    PictureStamps stamps{begin_ns - 2 * ns_per_s, *Rate::create(25, 1)};

private:
    std::int64_t now_ms_ = 0;
};

TEST_F(PictureStampsTest, PicturesHaveTheirInstants) {
    EXPECT_EQ(stamps.of_first(at_ms(-700), at_ms(0)), at_ms(-700));
    for (int i = 1; i < 100; ++i)
        EXPECT_EQ(stamps.of_new(at_ms(40 * i), at_ms(40 * i + (i % 7) * 20), false), at_ms(40 * i));
}

TEST_F(PictureStampsTest, AfterARepeatALatePictureHasItsInstantOrIsLeftOut) {
    stamps.of_first(at_ms(0), at_ms(0));
    EXPECT_EQ(repeats_until(1000), 1);
    EXPECT_EQ(stamps.of_new(at_ms(520), at_ms(1010), false), at_ms(520));  // before now, after the repeat
    EXPECT_EQ(repeats_until(2100), 1);
    EXPECT_EQ(stamps.of_new(at_ms(560), at_ms(2110), false), std::nullopt);  // a stall in the middle of drawing
    EXPECT_EQ(stamps.of_new(at_ms(2080), at_ms(2120), false), at_ms(2080));
}

TEST_F(PictureStampsTest, PicturesThatAreLateAgainAndAgainAreNotLeftOut) {
    stamps.of_first(at_ms(0), at_ms(0));
    int left_out = 0;
    for (int s = 1; s < 20; ++s) {
        repeats_until(4000 * s);
        const auto stamp_ns = stamps.of_new(at_ms(4000 * s - 3500), at_ms(4000 * s), false);
        left_out += stamp_ns ? 0 : 1;
        EXPECT_EQ(stamp_ns.value_or(at_ms(4000 * s - 3500)), at_ms(4000 * s - 3500));
    }
    EXPECT_LE(left_out, 1);
}

TEST_F(PictureStampsTest, InLockstepALatePictureIsSentWithTheNextTick) {
    stamps.of_first(at_ms(0), at_ms(0));
    EXPECT_EQ(repeats_until(2000), 2);
    const auto late = stamps.of_new(at_ms(40), at_ms(2010), true);
    ASSERT_TRUE(late);
    EXPECT_GT(*late, at_ms(1500));
    EXPECT_LT(*late, at_ms(1501));
}

TEST_F(PictureStampsTest, TheLastPictureComesAgainEachSecondAndMoreOftenForANewClient) {
    EXPECT_EQ(stamps.of_join(at_ms(0)), std::nullopt);  // there is none yet
    EXPECT_EQ(repeats_until(1000), 0);
    stamps.of_first(at_ms(-9000), at_ms(1000));
    EXPECT_EQ(repeats_until(2000), 1);
    EXPECT_NEAR(repeats_until(5000), 30, 1);
    EXPECT_NEAR(repeats_until(10'000), 5, 1);
    EXPECT_TRUE(stamps.of_join(at_ms(10'900)));
    EXPECT_EQ(stamps.of_join(at_ms(10'950)), std::nullopt);
}

TEST_F(PictureStampsTest, ASlowStreamSendsNothingTwiceBetweenItsPictures) {
    PictureStamps slow(begin_ns, *Rate::create(1, 2));
    slow.of_first(at_ms(0), at_ms(0));
    for (int s = 2; s <= 20; s += 2) {
        EXPECT_EQ(repeats_until(1000 * s, slow), 0);
        EXPECT_EQ(slow.of_new(at_ms(1000 * s), at_ms(1000 * s), false), at_ms(1000 * s));
    }
    EXPECT_EQ(repeats_until(29'900, slow), 2) << "the world stands still";
    // Programs on ffmpeg's libraries wait for 20 pictures whatever the rate.
    slow.of_join(at_ms(30'000));
    EXPECT_NEAR(repeats_until(33'000, slow), 30, 2);
}

TEST_F(PictureStampsTest, StampsRiseWhateverComesInWhateverOrder) {
    std::mt19937_64 random(1);
    TimeNs now_ns = begin_ns, last_ns = stamps.of_first(begin_ns - 60 * ns_per_s, now_ns);
    for (int i = 0; i < 100'000; ++i) {
        now_ns += static_cast<TimeNs>(random() % (300 * ns_per_ms));
        const TimeNs late_ns = static_cast<TimeNs>(random() % (random() % 8 == 0 ? 3 * ns_per_s : frame_ns));
        const std::uint64_t what = random() % 20;
        const auto stamp_ns = what == 0   ? stamps.of_join(now_ns)
                              : what < 16 ? stamps.of_repeat(now_ns)
                                          : stamps.of_new(now_ns - late_ns, now_ns, what == 16);
        if (!stamp_ns) continue;
        ASSERT_GE(*stamp_ns - last_ns, ns_per_s / 90'000);
        ASSERT_LE(*stamp_ns, now_ns + ns_per_ms);
        last_ns = *stamp_ns;
    }
}

}  // namespace
}  // namespace camrig::rtsp
