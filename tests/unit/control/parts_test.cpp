
#include <gmock/gmock.h>

#include "control/client/endpoint.h"
#include "control/server/line_buffer.h"
#include "core/base/base64.h"

namespace camrig::control {
namespace {

std::vector<std::byte> bytes_of(std::string_view text) {
    const auto* first = reinterpret_cast<const std::byte*>(text.data());
    return {first, first + text.size()};
}

TEST(Base64, GivesTheVectorsOfTheStandard) {
    const std::pair<const char*, const char*> vectors[] = {{"", ""},
                                                           {"f", "Zg=="},
                                                           {"fo", "Zm8="},
                                                           {"foo", "Zm9v"},
                                                           {"foob", "Zm9vYg=="},
                                                           {"fooba", "Zm9vYmE="},
                                                           {"foobar", "Zm9vYmFy"}};
    for (const auto& [plain, coded] : vectors) {
        EXPECT_STREQ(base64_encode(bytes_of(plain)).c_str(), coded);  // nothing is written behind the end
        EXPECT_EQ(base64_decode(coded).value(), bytes_of(plain));
    }
}

TEST(Base64, WhatIsNotBase64IsRefused) {
    for (const char* text : {"Z", "Zg=", "Zg===", "Zm 9", "====", "Zg==Zg==", "Zm9\xff", "Zg-_"})
        EXPECT_FALSE(base64_decode(text)) << text;
}

// No encoder makes them, browsers read them: RFC 4648, section 3.5.
TEST(Base64, BitsBehindTheLastByteAreOfNoAccount) {
    EXPECT_EQ(base64_decode("Zh==").value(), bytes_of("f"));
    EXPECT_EQ(base64_decode("Zm9=").value(), bytes_of("fo"));
}

TEST(LineBuffer, CutsLinesWhereverTheyAreSplit) {
    LineBuffer lines(100);
    lines.append("one\ntw");
    EXPECT_EQ(lines.next_line(), "one");
    EXPECT_EQ(lines.next_line(), std::nullopt);
    lines.append("o\r\n\nrest");
    EXPECT_EQ(lines.next_line(), "two");
    EXPECT_EQ(lines.next_line(), "");
    EXPECT_EQ(lines.next_line(), std::nullopt);
    EXPECT_EQ(lines.rest(), "rest");
}

TEST(LineBuffer, ALineOfTheLimitPassesAndALongerOneDoesNot) {
    LineBuffer lines(4);
    lines.append("1234\n12345");
    EXPECT_EQ(lines.next_line(), "1234");
    EXPECT_EQ(lines.next_line(), std::nullopt);
    EXPECT_TRUE(lines.too_long());
    LineBuffer complete(4);
    complete.append("12345\n");
    EXPECT_EQ(complete.next_line(), std::nullopt);
    EXPECT_TRUE(complete.too_long());
}

TEST(Endpoint, HostAndPortAreTcpAndAllElseIsAPath) {
    EXPECT_EQ(client::Endpoint::parse("/tmp/a.sock")->unix_path, "/tmp/a.sock");
    EXPECT_EQ(client::Endpoint::parse("a.sock")->unix_path, "a.sock");
    EXPECT_EQ(client::Endpoint::parse("./a:1")->unix_path, "./a:1");
    EXPECT_EQ(client::Endpoint::parse("localhost:9000")->port, 9000);
    EXPECT_EQ(client::Endpoint::parse("[::1]:9000")->host, "::1");
    for (const char* wrong : {"", ":9000", "host:", "host:0", "host:70000", "host:9x"})
        EXPECT_FALSE(client::Endpoint::parse(wrong)) << wrong;
}

}  // namespace
}  // namespace camrig::control
