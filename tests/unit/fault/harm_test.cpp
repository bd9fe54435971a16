#include "core/fault/harm.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/fault/sending.h"
#include "tests/unit/fault/faulty.h"

namespace camrig::fault::harm_test {
namespace {

std::vector<std::byte> jpeg(int bytes) {
    std::vector<std::byte> out;
    for (const int value : {0xFF, 0xD8, 0xFF, 0xDA, 0, 2}) out.push_back(std::byte(value));
    for (int i = 6; i < bytes; ++i) out.push_back(std::byte(i * 37 % 251 + 1));
    return out;
}

Damaged damaged(const CorruptJpeg& how, int bytes) {
    return damaged_jpeg(at_frame(fault_of(how), 4), "mjpeg", jpeg(bytes)).value();
}

TEST(Harm, IsWhatADamagedJpegIsMadeOf) {
    const auto whole = jpeg(5000);
    for (const Damage mode : {Damage::bitflip, Damage::zero}) {
        const Damaged got = damaged({.mode = mode, .amount = 30}, 5000);
        ASSERT_EQ(got.harms.size(), 1U);
        std::vector<std::byte> healed = got.bytes;
        std::size_t bytes = 0;
        for (const Harm::Run& run : got.harms[0].first) {
            bytes += run.bytes;
            for (std::size_t i = run.offset; i < run.offset + run.bytes; ++i) EXPECT_NE(got.bytes[i], whole[i]);
            std::copy_n(&whole[run.offset], run.bytes, &healed[run.offset]);
        }
        EXPECT_EQ(healed, whole) << to_string(mode);
        EXPECT_EQ(got.harms[0].bytes, bytes);
        EXPECT_EQ(got.harms[0].mode, to_string(mode));
        EXPECT_EQ(got.harms[0].kind, "corrupt_jpeg");
    }
    for (const Damage mode : {Damage::cut, Damage::truncate, Damage::truncate_eoi}) {
        const Damaged got = damaged({.mode = mode, .amount = 700}, 5000);
        const Harm::Run run = got.harms.at(0).first.at(0);
        EXPECT_EQ(run.bytes, 700U);
        std::vector<std::byte> cut = whole;
        cut.erase(cut.begin() + static_cast<std::ptrdiff_t>(run.offset),
                  cut.begin() + static_cast<std::ptrdiff_t>(run.offset + run.bytes));
        if (mode == Damage::truncate_eoi) cut.insert(cut.end(), {std::byte{0xFF}, std::byte{0xD9}});
        EXPECT_EQ(got.bytes, cut) << to_string(mode);
        EXPECT_EQ(got.harms[0].size, 5000U);
    }
}

TEST(Harm, ListsTheFirstRunsAndCountsAll) {
    const auto whole = jpeg(9000);
    const Damaged got = damaged({.mode = Damage::bitflip, .amount = 1000}, 9000);
    const Harm& harm = got.harms.at(0);
    std::size_t bytes = 0, runs = 0;
    for (std::size_t i = 0; i < whole.size(); ++i) {
        if (got.bytes[i] == whole[i]) continue;
        ++bytes;
        runs += i == 0 || got.bytes[i - 1] == whole[i - 1];
    }
    EXPECT_EQ(harm.bytes, bytes);
    EXPECT_EQ(harm.runs, runs);
    EXPECT_EQ(harm.first.size(), Harm::max_runs);
    EXPECT_GT(runs, Harm::max_runs);
}

TEST(HarmLog, KeepsWhatWasSentOnceWhoeverGotItAndNoMoreThanItMay) {
    HarmLog log;
    const auto harm = [](std::size_t size) {
        Harm one{.fault = 1, .kind = "corrupt_jpeg", .mode = "cut", .size = size, .first = {}};
        one.add(10, 5);
        return one;
    };
    log.add("mjpeg", harm(300));
    log.add("mjpeg", harm(200));
    log.add("mjpeg", harm(300));
    log.add("rtsp", harm(300));
    log.add("mjpeg", Harm{});
    const auto noted = log.entries("mjpeg");
    ASSERT_EQ(noted.first.size(), 2U);
    EXPECT_EQ(noted.first[0].harm.size, 200U);
    EXPECT_EQ(noted.first[1].times, 2U);
    EXPECT_EQ(log.entries("rtsp").first.size(), 1U);
    EXPECT_TRUE(log.entries("device").first.empty());
    for (std::size_t i = 0; i < 30; ++i) log.add("mjpeg", harm(1000 + i));
    EXPECT_EQ(log.entries("mjpeg").first.size(), HarmLog::max_entries);
    EXPECT_EQ(log.entries("mjpeg").left_out, 2 + 30 - HarmLog::max_entries);
}

}  // namespace
}  // namespace camrig::fault::harm_test
