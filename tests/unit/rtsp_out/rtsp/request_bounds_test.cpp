#include "rtsp_out/rtsp/request_bounds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/log_pace.h"
#include "rtsp_out/rtsp/failed_logins.h"

namespace camrig::rtsp {
namespace {

using testing::HasSubstr;

constexpr TimeNs now = 100 * ns_per_s;

/// What is said of these bytes by one who sees them at once, and by one who sees them singly.
Result<void> taken(RequestBounds bounds, const std::string& bytes) {
    RequestBounds singly = bounds;
    Result<void> good;
    for (std::size_t i = 0; i < bytes.size() && good; ++i)
        good = singly.take(std::string_view(bytes).substr(i, 1), now);
    const auto at_once = bounds.take(bytes, now);
    EXPECT_EQ(good.has_value(), at_once.has_value());
    EXPECT_EQ(singly.message_began_ns(), bounds.message_began_ns());
    return at_once;
}

Result<void> taken(const std::string& bytes) {
    return taken(RequestBounds(), bytes);
}

std::string request(const std::string& fields, const std::string& body = "") {
    return "DESCRIBE rtsp://127.0.0.1:8554/lobby RTSP/1.0\r\nCSeq: 1\r\n" + fields + "\r\n" + body;
}

TEST(RequestBounds, WhatStockClientsSendPasses) {
    EXPECT_TRUE(taken(request("Accept: application/sdp\r\nUser-Agent: Lavf59.27.100\r\n")));
    EXPECT_TRUE(taken("OPTIONS * RTSP/1.0\r\nCSeq: 1\r\nX-Empty:\r\n\r\n" + request("")));
    EXPECT_TRUE(taken("\r\n\r\n" + request("Content-Length: 3\r\n", "a\nb") + request("content-length:0\r\n")));
    EXPECT_TRUE(taken("DESCRIBE rtsp://x/lobby RTSP/9.9\r\n\r\n"));  // the library says what it thinks of it
}

TEST(RequestBounds, EachBoundHoldsToTheByte) {
    RequestLimits limits;
    limits.line_bytes = 60;
    limits.head_bytes = 170;
    limits.header_lines = 4;
    limits.body_bytes = 9;
    const RequestBounds bounds(limits);
    const auto line = [](std::size_t size) { return "a:" + std::string(size - 2, 'b') + "\r\n"; };
    EXPECT_TRUE(taken(bounds, request(line(60))));
    EXPECT_FALSE(taken(bounds, request(line(61))));
    EXPECT_TRUE(taken(bounds, request("a:b\r\na:b\r\na:b\r\n")));
    EXPECT_FALSE(taken(bounds, request("a:b\r\na:b\r\na:b\r\na:b\r\n")));
    const std::size_t used = request("").size() + 62;
    EXPECT_TRUE(taken(bounds, request(line(60) + line(170 - used - 2))));
    EXPECT_FALSE(taken(bounds, request(line(60) + line(170 - used - 1))));
    EXPECT_TRUE(taken(bounds, request("Content-Length: 9\r\n", "123456789") + request("")));
    EXPECT_FALSE(taken(bounds, request("Content-Length: 10\r\n")));
    EXPECT_TRUE(taken(bounds, std::string(170, '\n')));
    EXPECT_FALSE(taken(bounds, std::string(171, '\n')));
}

TEST(RequestBounds, WhatCouldBeReadInTwoWaysIsRefused) {
    for (const std::string& bad :
         {request("Content-Length: 1\r\nContent-Length: 1\r\n"), request("Content-Length: 1x\r\n"),
          request("Content-Length: -1\r\n"), request("Content-Length:\r\n"),
          request("Content-Length: 99999999999999999999\r\n"), request("Content-Length : 5\r\n"),
          request("a: b\r\n folded\r\n"), request("no field\r\n"), request("a: b\nc: d\r\n"), request("a: b\r\r\n"),
          request(std::string("a: \0\r\n", 6)), request(": b\r\n"), std::string("RTSP/1.0 200 OK\r\n\r\n"),
          std::string("GET / HTTP/1.1\r\n\r\n"), std::string("POST / HTTP/1.0\r\n\r\n"),
          std::string("DESCRIBE\r\n\r\n"), std::string("DESCRIBE RTSP/1.0\r\n\r\n"),
          std::string(" OPTIONS * RTSP/1.0\r\n\r\n")}) {
        const auto said = taken(bad);
        ASSERT_FALSE(said) << bad;
        EXPECT_FALSE(said.error().message.empty());
    }
}

TEST(RequestBounds, PacketsPassOnlyOnceAStreamIsSetUp) {
    const std::string packet = std::string("$\1\0\4", 4) + "\r\n$x";
    RequestBounds bounds;
    EXPECT_FALSE(taken(bounds, packet));
    bounds.allow_data();
    EXPECT_TRUE(taken(bounds, packet + request("") + packet + std::string("$\0\0\0", 4) + packet));
    EXPECT_FALSE(taken(bounds, "$\1\xff\xff"));
}

TEST(RequestBounds, MessagesOfOneSecondAreCounted) {
    RequestLimits limits;
    limits.messages_per_s = 3;
    RequestBounds bounds(limits);
    const auto ask = [&](TimeNs at) { return bounds.take(request(""), at).has_value(); };
    EXPECT_TRUE(ask(now) && ask(now) && ask(now + ns_per_s - 1));
    EXPECT_TRUE(ask(now + ns_per_s) && ask(now + ns_per_s) && ask(now + ns_per_s));
    EXPECT_FALSE(ask(now + ns_per_s + 1));
}

TEST(RequestBounds, ItTellsSinceWhenAMessageIsOnItsWay) {
    RequestBounds bounds;
    EXPECT_EQ(bounds.message_began_ns(), 0);
    EXPECT_TRUE(bounds.take("OPTIONS * ", now));
    EXPECT_TRUE(bounds.take("RTSP/1.0\r\nContent-Length: 2\r\n\r\nx", now + 5));
    EXPECT_EQ(bounds.message_began_ns(), now);
    EXPECT_TRUE(bounds.take("x", now + 6));
    EXPECT_EQ(bounds.message_began_ns(), 0);
}

TEST(FailedLogins, AnAddressThatGuessesWaitsUntilAMinuteAfterItsLastGuess) {
    FailedLogins failed;
    for (int i = 0; i < FailedLogins::free_failures; ++i) failed.add("10.0.0.1", now);
    EXPECT_FALSE(failed.must_wait("10.0.0.1", now));
    failed.add("10.0.0.1", now);
    EXPECT_TRUE(failed.must_wait("10.0.0.1", now + FailedLogins::memory_ns));
    EXPECT_FALSE(failed.must_wait("10.0.0.1", now + FailedLogins::memory_ns + 1));
    EXPECT_FALSE(failed.must_wait("10.0.0.2", now));
    failed.add("10.0.0.1", now + 2 * FailedLogins::memory_ns);  // counts from the beginning
    EXPECT_FALSE(failed.must_wait("10.0.0.1", now + 2 * FailedLogins::memory_ns));
}

TEST(LogPace, OneLineASecondAndTheNextTellsHowManyWereLeftOut) {
    LogPace pace;
    EXPECT_EQ(pace.due(now), 0);
    EXPECT_EQ(pace.due(now + 1), std::nullopt);
    EXPECT_EQ(pace.due(now + ns_per_s - 1), std::nullopt);
    EXPECT_EQ(pace.due(now + ns_per_s), 2);
}

}  // namespace
}  // namespace camrig::rtsp
