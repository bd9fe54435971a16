#include "rtsp_out/http/reply.h"

#include <algorithm>
#include <cstring>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rtsp_out/http/npy.h"

namespace camrig::http {
namespace {

/// A thread that is interrupted between two clocks reads a wrong difference: one instant has one time all the same.
TEST(FrameFields, APictureHasTheSameTimeOfDayUntilTheClockIsSet) {
    TimeNs measured_ns = 1'790'000'000 * ns_per_s;
    WallOffset wall([&] { return measured_ns; });
    frame::FrameInfo info;
    info.world_ns = info.monotonic_ns = 250 * ns_per_ms;
    info.clock = ClockReading{};
    const auto timestamp = [&] {
        const auto fields = frame_fields(info, wall);
        return std::ranges::find(fields, "X-Timestamp", [](const auto& field) { return field.first; })->second;
    };
    EXPECT_EQ(timestamp(), "1790000000.250000");
    measured_ns += 20 * ns_per_ms;
    EXPECT_EQ(timestamp(), "1790000000.250000");
    measured_ns += 3600 * ns_per_s;
    EXPECT_EQ(timestamp(), "1790003600.270000");
}

TEST(Reply, ErrorsAreJsonWithTheKindOfTheControlProtocol) {
    const Reply reply = error_reply({ErrorKind::not_found, "no \"camera\" \xff here"});
    EXPECT_EQ(reply.status, 404);
    const auto body = nlohmann::json::parse(reply.text);
    EXPECT_EQ(body["error"]["kind"], "not_found");
    EXPECT_FALSE(body["error"]["message"].get<std::string>().empty());
}

TEST(Reply, HeadNamesLengthAndWhetherTheConnectionStays) {
    Reply reply = text_reply("text/plain", "four");
    EXPECT_TRUE(head_of(reply, 11, true).starts_with("HTTP/1.1 200 OK\r\n"));
    EXPECT_NE(head_of(reply, 11, true).find("\r\nContent-Length: 4\r\n"), std::string::npos);
    EXPECT_EQ(head_of(reply, 11, true).find("Connection"), std::string::npos);
    EXPECT_NE(head_of(reply, 11, false).find("\r\nConnection: close\r\n"), std::string::npos);
    EXPECT_NE(head_of(reply, 10, true).find("\r\nConnection: keep-alive\r\n"), std::string::npos);
    EXPECT_TRUE(head_of(reply, 10, false).ends_with("\r\n\r\n"));
    EXPECT_EQ(head_of(reply, 11, false).find("Access-Control"), std::string::npos);
}

TEST(Reply, EntityTagsTellPicturesApart) {
    frame::FrameInfo info;
    info.sequence = 17;
    const std::vector<std::byte> one(100, std::byte{1}), other(100, std::byte{2});
    const std::string etag = etag_of(info, one);
    EXPECT_EQ(etag, etag_of(info, one));
    EXPECT_NE(etag, etag_of(info, other));
    EXPECT_TRUE(etag_matches("\"x\", " + etag, etag));
    EXPECT_TRUE(etag_matches("*", etag));
    EXPECT_FALSE(etag_matches(etag_of(info, other), etag));
    EXPECT_FALSE(etag_matches("", etag));
    info.sequence = 18;
    EXPECT_NE(etag, etag_of(info, one));
}

TEST(Npy, HeadIsVersionOneAndAlignedTo64) {
    for (const ImageSize size : {ImageSize{16, 16}, ImageSize{641, 479}, ImageSize{8192, 8192}}) {
        const std::string head = npy_float32_head(size);
        EXPECT_EQ(head.size() % 64, 0U);
        EXPECT_EQ(std::memcmp(head.data(), "\x93NUMPY\x01\x00", 8), 0);
        EXPECT_EQ(static_cast<unsigned char>(head[8]) + 256U * static_cast<unsigned char>(head[9]), head.size() - 10);
        EXPECT_EQ(head.back(), '\n');
        EXPECT_NE(head.find("'shape': (" + std::to_string(size.height) + ", " + std::to_string(size.width) + ")"),
                  std::string::npos);
    }
}

}  // namespace
}  // namespace camrig::http
