#include "rtsp_out/http/access.h"

#include <gtest/gtest.h>

namespace camrig::http {
namespace {

bool post_allowed(std::optional<std::string_view> origin, std::optional<std::string_view> site = {},
                  std::string_view host = "127.0.0.1:8080") {
    return check_origin({"POST", host, origin, site}, "127.0.0.1", false).has_value();
}

bool host_allowed(std::string_view host, std::string_view configured = "127.0.0.1", bool token = false) {
    return check_origin({"GET", host, {}, {}}, configured, token).has_value();
}

TEST(Access, TokenComesFromHeaderThenQueryThenCookie) {
    const std::string query = "q";
    EXPECT_EQ(token_of("Bearer h", &query, "camrig_token=c"), "h");
    EXPECT_EQ(token_of("bearer   h", nullptr, ""), "h");
    EXPECT_EQ(token_of("Basic eA==", &query, "camrig_token=c"), "q");
    EXPECT_EQ(token_of("", nullptr, "a=b; camrig_token=c; d=e"), "c");
    EXPECT_EQ(token_of("Bearer ", nullptr, "xcamrig_token=c"), "");
}

TEST(Access, OnlyThisMachinesNamesAreHostsWithoutToken) {
    for (const char* good :
         {"localhost", "LOCALHOST:80", "127.0.0.1", "127.1.2.3:9", "[::1]", "[::1]:8080", "rig.localhost"})
        EXPECT_TRUE(host_allowed(good)) << good;
    for (const char* bad : {"", "evil.com", "evil.com:8080", "127.0.0.1.evil.com", "localhost.evil.com", "[", "[::2]",
                            "10.0.0.1", "127.evil.0.1", "xlocalhost"})
        EXPECT_FALSE(host_allowed(bad)) << bad;
    EXPECT_TRUE(host_allowed("10.0.0.1:8080", "10.0.0.1"));
    EXPECT_TRUE(host_allowed("[fe80::1]:8080", "fe80::1"));
    EXPECT_TRUE(host_allowed("rig.example:8080", "0.0.0.0", true));
    // HTTP/1.0 programs send none; browsers always do.
    EXPECT_TRUE(check_origin({"GET", {}, {}, {}}, "127.0.0.1", false));
}

TEST(Access, ForeignPagesMayNotPost) {
    EXPECT_TRUE(post_allowed({}));
    EXPECT_TRUE(post_allowed("http://127.0.0.1:8080"));
    EXPECT_TRUE(post_allowed("http://127.0.0.1:8080", "same-origin"));
    EXPECT_FALSE(post_allowed("http://127.0.0.1:9000"));
    EXPECT_FALSE(post_allowed("http://evil.com"));
    EXPECT_FALSE(post_allowed("null"));
    EXPECT_FALSE(post_allowed(""));
    EXPECT_FALSE(post_allowed("http://127.0.0.1:8080", "cross-site"));
    EXPECT_FALSE(post_allowed({}, "same-site"));
    EXPECT_FALSE(post_allowed("http://evil.com", {}, "evil.com"));
}

}  // namespace
}  // namespace camrig::http
