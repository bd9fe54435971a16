#include <cmath>

#include <gtest/gtest.h>

#include "core/fault/body.h"
#include "core/fault/delivery.h"
#include "core/fault/line.h"
#include "core/fault/picture.h"
#include "core/fault/sending.h"
#include "core/fault/standing.h"
#include "tests/unit/fault/faulty.h"

// Every kind of the table at rising severities, by one measure of how far its frames are from unharmed ones. A kind
// that nobody thought of here fails, for its measure stays 0.
namespace camrig::fault::severity_test {
namespace {

constexpr ImageSize size{64, 48};

double pixel_harm(const FrameFaults& faults) {
    std::vector<std::byte> rgba;
    for (int i = 0; i < size.width * size.height; ++i)
        for (const int value : {i % 64 * 3, i / 64 * 4, 60 + i % 7 * 9, 255}) rgba.push_back(std::byte(value));
    const auto before = rgba;
    change_picture(faults, size, rgba);
    double harm = 0.0;
    for (std::size_t i = 0; i < rgba.size(); ++i)
        harm += std::abs(std::to_integer<int>(rgba[i]) - std::to_integer<int>(before[i]));
    return harm + 1000.0 * torn_rows(faults, size.height);
}

double jpeg_harm(const FrameFaults& faults) {
    std::vector<std::byte> jpeg(4000, std::byte{0x5A});
    const std::byte head[] = {std::byte{0xFF}, std::byte{0xD8}, std::byte{0xFF},
                              std::byte{0xDA}, std::byte{0},    std::byte{2}};
    std::copy(std::begin(head), std::end(head), jpeg.begin());
    const auto damaged = damaged_jpeg(faults, "mjpeg", jpeg);
    double harm = 0.0;
    for (std::size_t i = 0; damaged && i < std::min(jpeg.size(), damaged->bytes.size()); ++i)
        harm += damaged->bytes[i] != jpeg[i];
    return harm;
}

double slice_harm(const FrameFaults& faults) {
    std::vector<std::byte> slice(2000, std::byte{0x7F});
    std::vector<Harm> harms;
    damage_slice(faults, 0, slice, 0, slice.size(), harms);
    return static_cast<double>(std::ranges::count_if(slice, [](std::byte one) { return one != std::byte{0x7F}; })) +
           1000.0 * (slice_dropper(faults, 0, true) != nullptr);
}

double body_harm(const FrameFaults& faults) {
    const camera::Pose pose;
    return 1e6 * (1.0 - std::abs(glm::dot(moved(faults, pose).orientation, pose.orientation)));
}

/// Of a second of frames, and of the packets of each.
double harm(const FaultKind& kind, double severity) {
    Line line;
    double sum = 0.0;
    std::uint64_t epoch = 0;
    for (int i = 0; i < 250; ++i) {
        FrameFaults faults = at_frame(fault_of(kind, severity), i);
        sum += is_dropped(faults) + is_repeat(faults, faults.frame.world_ns - 1) + is_stalled(faults, "rtsp") +
               is_disconnected(faults, "rtsp") + cut_part(faults, 100).has_value() + part_error(faults).has_value() +
               has_buffer_error(faults) + (unplug_of(faults) != nullptr) +
               static_cast<double>(frames_late(faults, "rtsp")) + standing_of(faults).refused +
               standing_of(faults).device_errors +
               static_cast<double>(bytes_missing(faults, 10'000).value_or(Harm{}).bytes) +
               !line.takes(line_rate(faults, "rtsp"), faults.frame.world_ns, 10'000) + body_harm(faults);
        if (const auto other = other_size(faults, "mjpeg", size))
            sum += static_cast<double>(size.pixels() - other->pixels());
        sum += std::exchange(epoch, ssrc_epoch(faults)) != epoch;
        for (std::uint64_t packet = 0; packet < 20; ++packet)
            sum += (packet_loser(faults, static_cast<std::uint64_t>(i) << 16 | packet) != nullptr) +
                   packet_distance(faults, static_cast<std::uint64_t>(i) << 16 | packet) +
                   1e-9 * static_cast<double>(packet_delay_ns(faults, static_cast<std::uint64_t>(i) << 16 | packet));
        sum += jpeg_harm(faults) + slice_harm(faults);
        if (i == 40) sum += pixel_harm(faults);
    }
    return sum;
}

TEST(Severity, OfEveryKindIsNeverMilderWhenItIsMoreAndDoesSomethingAtOne) {
    for (const auto& kind : fault_kinds()) {
        const nlohmann::json none = nlohmann::json::object();
        JsonReader reader(none, "");
        const FaultKind made = kind.read(reader);
        double milder = 0.0;
        for (const double severity : {0.1, 0.3, 0.5, 0.8, 1.0}) {
            const double now = harm(made, severity);
            // Bits that are flipped twice are whole again.
            EXPECT_GE(now, 0.97 * milder) << name_of(made) << " " << severity;
            milder = now;
        }
        EXPECT_GT(milder, 0.0) << name_of(made);
    }
}

TEST(Severity, MirroredAndUpsideDownActFullyAboveZero) {
    for (const FaultKind& kind : {FaultKind(Mirrored{}), FaultKind(UpsideDown{})}) {
        EXPECT_GT(harm(kind, 0.001), 0.0);
        EXPECT_EQ(harm(kind, 0.001), harm(kind, 1.0));
    }
}

}  // namespace
}  // namespace camrig::fault::severity_test
