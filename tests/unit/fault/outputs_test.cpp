#include <gtest/gtest.h>

#include "core/fault/delivery.h"
#include "core/fault/line.h"
#include "core/fault/sending.h"
#include "core/fault/standing.h"
#include "tests/unit/fault/faulty.h"

namespace camrig::fault::outputs_test {
namespace {

TEST(Late, FramesComeSoManyLaterOnTheOutputThatWasAskedFor) {
    const FaultRef fault = fault_of(Late{.frames = 6, .output = Output::rtsp}, 0.5);
    EXPECT_EQ(frames_late(at_frame(fault, 10), "rtsp"), 3);
    EXPECT_EQ(frames_late(at_frame(fault, 10), "mjpeg"), 0);
    EXPECT_EQ(frames_late(at_frame(fault_of(Stall{}), 10), "rtsp"), 0);
}

TEST(Late, InBurstsAllComeWithTheLastOfThem) {
    const FaultRef fault = fault_of(Late{.frames = 4, .in_bursts = true});
    for (int i = 100; i < 200; ++i) {
        const auto comes_with = i + frames_late(at_frame(fault, i), "device");
        EXPECT_EQ(comes_with % 5, 4) << i;
        EXPECT_LT(comes_with - i, 5);
    }
}

TEST(Restart, ThrowsReadersOutAndRefusesThemForItsShareOfEachPeriod) {
    const FaultRef fault = fault_of(Restart{.period_s = 2.0, .output = Output::rtsp}, 0.25);
    for (int i = 0; i < 200; ++i) {
        const FrameFaults faults = at_frame(fault, i);
        const bool is_down = i % 50 < 13;  // frames are 40 ms apart: 0.5 s
        EXPECT_EQ(is_disconnected(faults, "rtsp"), is_down) << i;
        EXPECT_EQ(standing_of(faults).refuses("rtsp"), is_down) << i;
        EXPECT_FALSE(is_disconnected(faults, "mjpeg") || standing_of(faults).refuses("mjpeg"));
    }
}

TEST(Refuse, LetsThoseStayWhoAreThere) {
    const FrameFaults faults = at_frame(fault_of(Refuse{}), 3);
    EXPECT_FALSE(is_disconnected(faults, "rtsp"));
    for (const char* output : {"mjpeg", "rtsp", "device"}) EXPECT_TRUE(standing_of(faults).refuses(output)) << output;
    EXPECT_FALSE(Standing{}.refuses("rtsp"));
}

TEST(Refuse, IsNotOfLoopbackDevicesAndSaysWhyNot) {
    FaultPlan plan;
    for (const FaultKind& kind :
         {FaultKind(Refuse{.output = Output::v4l2}), FaultKind(Restart{.output = Output::v4l2})}) {
        const auto refused = plan.set({.kind = kind}, 1, 0, 0);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().kind, ErrorKind::unsupported);
        EXPECT_NE(refused.error().message.find("user-space device"), std::string::npos) << refused.error().message;
    }
}

TEST(DeviceError, NamesTheCallThatFails) {
    for (const DeviceCall call : {DeviceCall::reqbufs, DeviceCall::qbuf, DeviceCall::streamon, DeviceCall::streaming})
        EXPECT_EQ(standing_of(at_frame(fault_of(DeviceError{.at = call}), 1)).device_errors,
                  1u << static_cast<unsigned>(call));
    EXPECT_EQ(standing_of(at_frame(fault_of(Stall{}), 1)), Standing{});
}

TEST(PacketReorder, LetsTheShareBeOvertakenAndTheSameOnesAtAHigherSeverity) {
    std::vector<bool> milder(20'000, false);
    for (const double severity : {0.25, 0.5, 1.0}) {
        const FrameFaults faults = at_frame(fault_of(PacketReorder{.probability = 0.4, .distance = 5}, severity), 3);
        int moved = 0;
        for (std::size_t i = 0; i < milder.size(); ++i) {
            const int distance = packet_distance(faults, i);
            ASSERT_TRUE(distance == 0 || distance == 5);
            ASSERT_TRUE(distance == 5 || !milder[i]);
            milder[i] = distance == 5;
            moved += distance == 5;
        }
        EXPECT_NEAR(moved / 20'000.0, 0.4 * severity, 0.01);
    }
}

TEST(PacketDelay, LetsTheShareComeLateByWhatItWasToldAndTheSameOnesAtAHigherSeverity) {
    std::vector<TimeNs> milder(20'000, 0);
    for (const double severity : {0.25, 0.5, 1.0}) {
        const FaultRef fault = fault_of(PacketDelay{.probability = 0.4, .delay_s = 0.2, .jitter_s = 0.1}, severity);
        const FrameFaults faults = at_frame(fault, 3);
        int late = 0;
        double sum_s = 0.0;
        for (std::size_t i = 0; i < milder.size(); ++i) {
            const TimeNs now_ns = packet_delay_ns(faults, i);
            ASSERT_TRUE(milder[i] == 0 || now_ns == milder[i]) << i;
            milder[i] = now_ns;
            if (now_ns == 0) continue;
            ASSERT_GE(now_ns, 200 * ns_per_ms);
            ASSERT_LE(now_ns, 300 * ns_per_ms);
            ++late;
            sum_s += static_cast<double>(now_ns) * 1e-9;
        }
        EXPECT_NEAR(late / 20'000.0, 0.4 * severity, 0.01);
        EXPECT_NEAR(sum_s / late, 0.25, 0.005);
    }
}

TEST(NewSsrc, ChangesAtItsBeginAndOncePerPeriodAndMoreOftenAtAHigherSeverity) {
    const auto changes = [](double severity) {
        std::uint64_t last = 0;
        int count = 0;
        for (int i = 0; i < 500; ++i) {  // 20 s
            const std::uint64_t epoch = ssrc_epoch(at_frame(fault_of(NewSsrc{.period_s = 2.0}, severity), i));
            EXPECT_NE(epoch, 0u);
            count += epoch != last;
            last = epoch;
        }
        return count;
    };
    EXPECT_EQ(changes(1.0), 10);
    EXPECT_EQ(changes(0.5), 5);
    EXPECT_EQ(ssrc_epoch(at_frame(fault_of(Stall{}), 1)), 0u);
}

TEST(Bandwidth, ALineCarriesWhatItIsToldAndLosesTheRest) {
    for (const double severity : {1.0, 0.5}) {
        const FrameFaults faults = at_frame(fault_of(Bandwidth{.kbit_per_s = 400, .queue_s = 0.1}, severity), 0);
        Line line;
        std::int64_t carried = 0, last = -1;
        for (int i = 0; i < 2500; ++i) {  // 100 s of 10 kB each 40 ms: 2 Mbit/s
            if (!line.takes(line_rate(faults, "mjpeg"), i * 40 * ns_per_ms, 10'000)) continue;
            carried += 80'000;
            last = i;
        }
        EXPECT_NEAR(static_cast<double>(carried) / 100.0, 400e3 / severity, 4e3 / severity);
        EXPECT_GT(last, 2480);
    }
}

TEST(Bandwidth, WithoutItALineCarriesAllAndForgetsThatItWasBusy) {
    const FrameFaults faults = at_frame(fault_of(Bandwidth{.kbit_per_s = 1, .queue_s = 0, .output = Output::rtsp}), 0);
    EXPECT_FALSE(line_rate(faults, "mjpeg"));
    Line line;
    EXPECT_TRUE(line.takes(line_rate(faults, "rtsp"), 0, 1'000'000));
    EXPECT_FALSE(line.takes(line_rate(faults, "rtsp"), ns_per_s, 1));
    EXPECT_TRUE(line.takes(std::nullopt, ns_per_s, 1'000'000));
    EXPECT_TRUE(line.takes(line_rate(faults, "rtsp"), ns_per_s, 1));
}

TEST(Bandwidth, AWorldThatIsLoadedFindsTheLineFree) {
    const auto rate = line_rate(at_frame(fault_of(Bandwidth{.kbit_per_s = 8, .queue_s = 0.1}), 0), "mjpeg");
    Line line;
    EXPECT_TRUE(line.takes(rate, 100 * ns_per_s, 1000));
    EXPECT_FALSE(line.takes(rate, 100 * ns_per_s, 1000));
    EXPECT_TRUE(line.takes(rate, 0, 1000));
    EXPECT_FALSE(line.takes(rate, ns_per_s / 2, 1000));
    EXPECT_TRUE(line.takes(rate, ns_per_s, 1000));
}

TEST(OtherSize, IsSmallerAtAHigherSeverityAndNeverTooSmallToBeAPicture) {
    const ImageSize own{640, 480};
    EXPECT_EQ(other_size(at_frame(fault_of(OtherSize{.share = 0.5}), 1), "mjpeg", own), (ImageSize{320, 240}));
    EXPECT_EQ(other_size(at_frame(fault_of(OtherSize{.share = 0.5}, 0.5), 1), "mjpeg", own), (ImageSize{480, 360}));
    EXPECT_EQ(other_size(at_frame(fault_of(OtherSize{.share = 0.99}), 1), "mjpeg", {32, 16}), min_image_size);
    EXPECT_FALSE(other_size(at_frame(fault_of(OtherSize{.output = Output::device}), 1), "mjpeg", own));
    EXPECT_FALSE(other_size(at_frame(fault_of(OtherSize{.probability = 0.0}), 1), "mjpeg", own));
}

}  // namespace
}  // namespace camrig::fault::outputs_test
