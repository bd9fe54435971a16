#include "core/base/tcp_listener.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

namespace camrig {
namespace {

TEST(TcpListener, TakesConnectionsWhereItSays) {
    for (const char* host : {"127.0.0.1", "127.9.9.9", "localhost"}) {
        const auto listener = listen_tcp({.host = host});
        ASSERT_TRUE(listener) << listener.error().message;
        EXPECT_EQ(listener->address, host == std::string("localhost") ? "127.0.0.1" : host);
        const UniqueFd client(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
        sockaddr_in there{};
        socklen_t size = sizeof there;
        ASSERT_EQ(::getsockname(listener->fd.get(), reinterpret_cast<sockaddr*>(&there), &size), 0);
        EXPECT_EQ(ntohs(there.sin_port), listener->port);
        EXPECT_EQ(::connect(client.get(), reinterpret_cast<const sockaddr*>(&there), size), 0) << host;
    }
}

TEST(TcpListener, NamesBecomeNumbers) {
    EXPECT_EQ(resolve_address("http", "localhost"), "127.0.0.1");
    for (const char* number : {"127.9.9.9", "0.0.0.0", "::1"}) EXPECT_EQ(resolve_address("http", number), number);
    const auto none = resolve_address("http", "not an address");
    EXPECT_EQ(none.error().kind, ErrorKind::invalid_argument);
    EXPECT_TRUE(none.error().message.starts_with("http: host 'not an address' is not an address of this machine"));
}

TEST(TcpListener, OtherAddressesThanLoopbackNeedAToken) {
    for (const char* host : {"0.0.0.0", "::"}) {
        EXPECT_EQ(listen_tcp({.host = host}).error().kind, ErrorKind::invalid_argument) << host;
        EXPECT_TRUE(is_any_address(host));
        EXPECT_FALSE(is_loopback_address(host));
    }
    const auto open = listen_tcp({.host = "0.0.0.0", .asks_for_token = true});
    ASSERT_TRUE(open) << open.error().message;
    EXPECT_NE(open->port, 0);
    for (const char* host : {"127.0.0.1", "127.9.9.9", "::1", "localhost"}) {
        EXPECT_TRUE(is_loopback_address(host)) << host;
        EXPECT_FALSE(is_any_address(host)) << host;
    }
    for (const char* host : {"192.168.1.2", "::2", "example.org", ""}) EXPECT_FALSE(is_loopback_address(host)) << host;
}

TEST(TcpListener, SaysWhyItCannot) {
    const auto first = listen_tcp({.host = "127.0.0.1"});
    ASSERT_TRUE(first);
    const auto taken = listen_tcp({.name = "rtsp", .port_option = "--rtsp", .host = "127.0.0.1", .port = first->port});
    EXPECT_EQ(taken.error().kind, ErrorKind::unavailable);
    EXPECT_EQ(taken.error().message, "rtsp: cannot listen on 127.0.0.1 port " + std::to_string(first->port) +
                                         ": Address already in use; choose another --rtsp PORT (0: any free one)");
    // 192.0.2.0/24 is for examples (RFC 5737): no machine has it.
    EXPECT_EQ(listen_tcp({.host = "192.0.2.1", .asks_for_token = true}).error().kind, ErrorKind::unavailable);
    for (const char* host : {"", "not an address"})
        EXPECT_EQ(listen_tcp({.host = host}).error().kind, ErrorKind::invalid_argument) << host;
}

}  // namespace
}  // namespace camrig
