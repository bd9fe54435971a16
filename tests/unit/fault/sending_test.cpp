#include "core/fault/sending.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/unit/fault/faulty.h"

namespace camrig::fault {
namespace {

/// Markers as of a JPEG (SOI, a table, SOS with 2 bytes), 1000 bytes of data and EOI.
std::vector<std::byte> jpeg() {
    std::vector<std::byte> bytes;
    for (const int value : {0xFF, 0xD8, 0xFF, 0xDB, 0, 4, 1, 2, 0xFF, 0xDA, 0, 4, 3, 4})
        bytes.push_back(std::byte(value));
    for (int i = 0; i < 1000; ++i) bytes.push_back(std::byte(i % 251 + 1));
    bytes.insert(bytes.end(), {std::byte{0xFF}, std::byte{0xD9}});
    return bytes;
}
constexpr std::size_t header_bytes = 14;

std::size_t differing(const std::vector<std::byte>& damaged) {
    const auto whole = jpeg();
    std::size_t count = damaged.size() > whole.size() ? damaged.size() - whole.size() : whole.size() - damaged.size();
    for (std::size_t i = 0; i < std::min(damaged.size(), whole.size()); ++i) count += damaged[i] != whole[i];
    return count;
}

std::vector<std::byte> damaged(const CorruptJpeg& how, double severity = 1.0, std::int64_t frame = 5) {
    return damaged_jpeg(at_frame(fault_of(how, severity), frame), "mjpeg", jpeg())
        .value_or(Damaged{.bytes = jpeg(), .harms = {}})
        .bytes;
}

TEST(CorruptJpeg, DamagesAsManyBytesAsItIsToldBehindTheHeader) {
    EXPECT_EQ(damaged({.mode = Damage::truncate, .amount = 300}).size(), jpeg().size() - 300);
    const auto ended = damaged({.mode = Damage::truncate_eoi, .amount = 300});
    EXPECT_EQ(ended.size(), jpeg().size() - 298);
    EXPECT_EQ(ended.back(), std::byte{0xD9});
    EXPECT_EQ(damaged({.mode = Damage::cut, .amount = 300}).size(), jpeg().size() - 300);
    const auto zero = damaged({.mode = Damage::zero, .amount = 300});
    EXPECT_EQ(std::ranges::count(zero, std::byte{0}), std::ranges::count(jpeg(), std::byte{0}) + 300);
    EXPECT_EQ(differing(damaged({.mode = Damage::bitflip, .amount = 1})), 1U);
    for (const Damage mode : {Damage::truncate, Damage::truncate_eoi, Damage::cut, Damage::zero, Damage::bitflip}) {
        const auto all = damaged({.mode = mode, .amount = 100'000});
        EXPECT_TRUE(std::equal(all.begin(), all.begin() + header_bytes, jpeg().begin())) << static_cast<int>(mode);
    }
    EXPECT_TRUE(damaged({.mode = Damage::truncate, .amount = 100'000, .keep_header = false}).empty());
}

TEST(CorruptJpeg, LeavesTheHeaderWhereItIsNotSent) {
    for (const Damage mode : {Damage::truncate, Damage::truncate_eoi, Damage::cut, Damage::zero, Damage::bitflip}) {
        const FaultRef fault = fault_of(CorruptJpeg{.mode = mode, .amount = 100'000, .keep_header = false});
        const auto sent = damaged_jpeg(at_frame(fault, 5), "rtsp", jpeg());
        ASSERT_TRUE(sent);
        ASSERT_GE(sent->bytes.size(), header_bytes);
        EXPECT_TRUE(std::equal(sent->bytes.begin(), sent->bytes.begin() + header_bytes, jpeg().begin()))
            << static_cast<int>(mode);
    }
}

TEST(CorruptJpeg, IsTheSameForAFrameAndAnotherForTheNext) {
    const CorruptJpeg how{.mode = Damage::bitflip, .amount = 10};
    EXPECT_EQ(damaged(how), damaged(how));
    EXPECT_NE(damaged(how), damaged(how, 1.0, 6));
}

TEST(CorruptJpeg, HitsTheShareOfFramesAndTheOutputThatWereAskedFor) {
    const FaultRef fault = fault_of(CorruptJpeg{.probability = 0.25, .output = Output::mjpeg});
    int hit = 0;
    for (int i = 0; i < 4000; ++i) hit += damaged_jpeg(at_frame(fault, i), "mjpeg", jpeg()).has_value();
    EXPECT_NEAR(hit / 4000.0, 0.25, 0.02);
    for (int i = 0; i < 100; ++i) EXPECT_FALSE(damaged_jpeg(at_frame(fault, i), "device", jpeg()));
}

TEST(CorruptJpeg, DamagesMoreAtAHigherSeverityInEveryMode) {
    for (const Damage mode : {Damage::truncate, Damage::cut, Damage::zero, Damage::bitflip}) {
        std::size_t less = 0;
        for (const double severity : {0.1, 0.4, 0.7, 1.0}) {
            const auto after = damaged({.mode = mode, .amount = 400}, severity);
            const auto whole = jpeg();
            const std::size_t bytes =
                mode == Damage::truncate || mode == Damage::cut ? whole.size() - after.size() : differing(after);
            EXPECT_GT(bytes, less) << static_cast<int>(mode) << " " << severity;
            less = bytes;
        }
    }
}

TEST(CorruptJpeg, TakesAnyBytesForAJpeg) {
    for (const std::size_t length : {0, 1, 2, 3, 5, 13})
        for (const bool keeps : {true, false}) {
            const auto whole = jpeg();
            const std::vector<std::byte> part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
            const FaultRef fault = fault_of(CorruptJpeg{.mode = Damage::cut, .amount = 7, .keep_header = keeps});
            damaged_jpeg(at_frame(fault, 1), "mjpeg", part);
        }
}

TEST(Stall, LastsForItsShareOfEachPeriodAndOnOneOutput) {
    const FaultRef fault = fault_of(Stall{.period_s = 1.0, .output = Output::rtsp}, 0.4);
    for (int i = 0; i < 50; ++i) {
        EXPECT_EQ(is_stalled(at_frame(fault, i), "rtsp"), i % 25 < 10) << i;
        EXPECT_FALSE(is_stalled(at_frame(fault, i), "mjpeg"));
    }
    for (const char* output : {"mjpeg", "rtsp", "device", "v4l2"})
        EXPECT_TRUE(is_stalled(at_frame(fault_of(Stall{}), 3), output));
}

TEST(Stall, LastsLongerAtAHigherSeverity) {
    for (const FaultKind& kind : {FaultKind(Stall{}), FaultKind(Disconnect{.period_s = 2.0})}) {
        int fewer = 0;
        for (const double severity : {0.2, 0.5, 0.8, 1.0}) {
            int count = 0;
            for (int i = 0; i < 500; ++i) {
                const FrameFaults faults = at_frame(fault_of(kind, severity), i);
                count += is_stalled(faults, "rtsp") || is_disconnected(faults, "rtsp");
            }
            EXPECT_GT(count, fewer);
            fewer = count;
        }
        EXPECT_EQ(fewer, 500);
    }
}

TEST(Disconnect, NeverUnplugsALoopbackDeviceAndSaysWhyNot) {
    EXPECT_TRUE(is_disconnected(at_frame(fault_of(Disconnect{}), 0), "device"));
    EXPECT_FALSE(is_disconnected(at_frame(fault_of(Disconnect{}), 0), "v4l2"));
    FaultPlan plan;
    const auto refused = plan.set({.kind = Disconnect{.output = Output::v4l2}}, 1, 0, 0);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::unsupported);
    EXPECT_NE(refused.error().message.find("stall"), std::string::npos) << refused.error().message;
}

TEST(CutPart, CutsTheShareOfFramesAndTheSameOnesAtAHigherSeverity) {
    std::vector<bool> milder(20'000, false);
    for (const double severity : {0.25, 0.5, 1.0}) {
        const FaultRef fault = fault_of(CutPart{.probability = 0.4}, severity);
        int cut = 0;
        for (std::size_t i = 0; i < milder.size(); ++i) {
            const bool is_now = cut_part(at_frame(fault, static_cast<std::int64_t>(i)), 100).has_value();
            ASSERT_TRUE(is_now || !milder[i]);
            milder[i] = is_now;
            cut += is_now;
        }
        EXPECT_NEAR(cut / 20'000.0, 0.4 * severity, 0.01);
    }
}

TEST(PacketLoss, LosesTheShareOfPacketsAndTheSameOnesAtAHigherSeverity) {
    std::vector<bool> milder(20'000, false);
    for (const double severity : {0.25, 0.5, 1.0}) {
        const FrameFaults faults = at_frame(fault_of(PacketLoss{.probability = 0.4}, severity), 3);
        int lost = 0;
        for (std::size_t i = 0; i < milder.size(); ++i) {
            const bool is_lost = (packet_loser(faults, i) != nullptr);
            ASSERT_TRUE(is_lost || !milder[i]);
            milder[i] = is_lost;
            lost += is_lost;
        }
        EXPECT_NEAR(lost / 20'000.0, 0.4 * severity, 0.01);
    }
}

TEST(BadPart, HitsItsShareOfParts) {
    const FaultRef fault = fault_of(BadPart{.mode = PartError::boundary, .probability = 0.5}, 0.5);
    int hit = 0;
    for (int i = 0; i < 4000; ++i) hit += part_error(at_frame(fault, i)) == PartError::boundary;
    EXPECT_NEAR(hit / 4000.0, 0.25, 0.02);
    EXPECT_FALSE(part_error(at_frame(fault_of(Stall{}), 1)));
}

TEST(CorruptVideo, DropsSlicesOrKeyFramesAndMoreOfThemAtAHigherSeverity) {
    const auto dropped = [](VideoDamage mode, double severity, bool is_key) {
        const FaultRef fault = fault_of(CorruptVideo{.mode = mode, .probability = 0.5}, severity);
        std::vector<int> found;
        for (int i = 0; i < 1000; ++i)
            for (std::uint64_t slice = 0; slice < 3; ++slice)
                if (slice_dropper(at_frame(fault, i), slice, is_key) != nullptr)
                    found.push_back(3 * i + static_cast<int>(slice));
        return found;
    };
    EXPECT_NEAR(dropped(VideoDamage::drop_nal, 1.0, false).size() / 3000.0, 0.5, 0.03);
    EXPECT_TRUE(dropped(VideoDamage::drop_idr, 1.0, false).empty());
    EXPECT_EQ(dropped(VideoDamage::drop_idr, 1.0, true).size() % 3, 0U) << "all slices of a key frame";
    EXPECT_NEAR(dropped(VideoDamage::drop_idr, 1.0, true).size() / 3000.0, 0.5, 0.05);
    EXPECT_TRUE(dropped(VideoDamage::bitflip, 1.0, true).empty());
    for (const VideoDamage mode : {VideoDamage::drop_nal, VideoDamage::drop_idr}) {
        const auto less = dropped(mode, 0.3, true), more = dropped(mode, 0.8, true);
        EXPECT_TRUE(std::ranges::includes(more, less)) << static_cast<int>(mode);
        EXPECT_LT(less.size(), more.size());
    }
}

TEST(CorruptVideo, FlipsBitsButMakesNoStartCode) {
    std::vector<std::byte> slice(3000, std::byte{0x40});
    const FaultRef fault = fault_of(CorruptVideo{.amount = 5000, .probability = 1.0});
    std::vector<Harm> harms;
    damage_slice(at_frame(fault, 3), 0, slice, 500, 9000, harms);
    const auto hurt = std::ranges::count_if(slice, [](std::byte byte) { return byte != std::byte{0x40}; });
    EXPECT_GT(hurt, 1000);
    ASSERT_EQ(harms.size(), 1U);
    EXPECT_EQ(harms[0].bytes, static_cast<std::size_t>(hurt));
    EXPECT_EQ(harms[0].size, 9000U);
    EXPECT_EQ(harms[0].mode, "bitflip");
    const auto first = std::ranges::find_if(slice, [](std::byte byte) { return byte != std::byte{0x40}; });
    EXPECT_EQ(harms[0].first.front().offset, 500U + static_cast<std::size_t>(first - slice.begin()));
    EXPECT_TRUE(std::ranges::none_of(slice, [](std::byte byte) { return byte <= std::byte{3}; }));
    std::size_t less = 0;
    for (const double severity : {0.1, 0.5, 1.0}) {
        std::vector<std::byte> again(3000, std::byte{0x40});
        damage_slice(at_frame(fault_of(CorruptVideo{.amount = 400, .probability = 1.0}, severity), 3), 0, again, 0,
                     3000, harms);
        const auto hit = static_cast<std::size_t>(
            std::ranges::count_if(again, [](std::byte byte) { return byte != std::byte{0x40}; }));
        EXPECT_GT(hit, less);
        less = hit;
    }
}

TEST(BufferError, HitsItsShareOfFrames) {
    int hit = 0;
    for (int i = 0; i < 4000; ++i) hit += has_buffer_error(at_frame(fault_of(BufferError{.probability = 0.5}, 0.5), i));
    EXPECT_NEAR(hit / 4000.0, 0.25, 0.02);
}

TEST(WrongSize, LeavesOutMoreAtAHigherSeverity) {
    for (const auto& [severity, kept] : {std::pair(0.5, std::size_t{750}), {1.0, 500}, {0.001, 999}})
        EXPECT_EQ(bytes_missing(at_frame(fault_of(WrongSize{.share = 0.5}, severity), 1), 1000)->first,
                  std::vector({Harm::Run{kept, 1000 - kept}}));
    EXPECT_EQ(bytes_missing(at_frame(fault_of(WrongSize{.share = 1.0}), 1), 1000)->bytes, 1000U);
    EXPECT_FALSE(bytes_missing(at_frame(fault_of(Stall{}), 1), 1000));
}

TEST(Unplug, LastsForItsShareOfEachPeriod) {
    const FaultRef fault = fault_of(Unplug{.period_s = 1.0, .as_number = 3}, 0.4);
    for (int i = 0; i < 50; ++i) EXPECT_EQ(unplug_of(at_frame(fault, i)) != nullptr, i % 25 < 10) << i;
    EXPECT_EQ(unplug_of(at_frame(fault, 0))->as_number, 3);
}

}  // namespace
}  // namespace camrig::fault
