#include "rtsp_out/http/target.h"

#include <gtest/gtest.h>

namespace camrig::http {
namespace {

TEST(Target, PathAndQueryAreDecoded) {
    const auto target = parse_target("/cameras/lob%62y/stream.mjpg?fps=30000%2F1001&quality=80&x=");
    ASSERT_TRUE(target);
    EXPECT_EQ(target->path, "/cameras/lobby/stream.mjpg");
    ASSERT_NE(target->find("fps"), nullptr);
    EXPECT_EQ(*target->find("fps"), "30000/1001");
    EXPECT_EQ(*target->find("quality"), "80");
    EXPECT_EQ(*target->find("x"), "");
    EXPECT_EQ(target->find("y"), nullptr);
}

TEST(Target, PlusStandsForItselfBecauseTokensMayHoldIt) {
    const auto target = parse_target("/?token=a+b%2B");
    ASSERT_TRUE(target);
    EXPECT_EQ(*target->find("token"), "a+b+");
}

TEST(Target, AbsoluteFormAndAsteriskAreTaken) {
    EXPECT_EQ(parse_target("http://127.0.0.1:8080/cameras?x=1")->path, "/cameras");
    EXPECT_EQ(parse_target("http://host?x=1")->path, "/");
    EXPECT_EQ(parse_target("*")->path, "*");
}

TEST(Target, WhateverIsAmbiguousOrDangerousIsRefused) {
    for (const std::string text : {"",
                                   "cameras",
                                   "ftp://x/",
                                   "http://",
                                   "http:///x",
                                   "/../etc/passwd",
                                   "/cameras/../rpc",
                                   "/cameras/%2e%2e/rpc",
                                   "/./",
                                   "/cameras%2flobby/truth",
                                   "/a%00b",
                                   "/a%",
                                   "/a%4",
                                   "/a%zz",
                                   "/a%0d%0aX",
                                   "/caf%c3%a9",
                                   "/a b",
                                   "/a\\..\\b",
                                   "/%5c",
                                   "/?a=%00",
                                   "/?a=1&a=2",
                                   "/?a%0a=1",
                                   "/#x",
                                   "//evil/..",
                                   "/?\xff"}) {
        const auto target = parse_target(text);
        ASSERT_FALSE(target) << text;
        EXPECT_EQ(target.error().kind, ErrorKind::invalid_argument);
        EXPECT_FALSE(target.error().message.empty());
    }
    EXPECT_FALSE(parse_target(std::string_view("/a\0b", 4)));
}

TEST(Target, LengthAndNumberOfParametersAreBounded) {
    EXPECT_TRUE(parse_target("/" + std::string(max_target_length - 1, 'a')));
    EXPECT_FALSE(parse_target("/" + std::string(max_target_length, 'a')));
    std::string many = "/?";
    for (std::size_t i = 0; i < max_query_parameters; ++i) many += "p" + std::to_string(i) + "=1&";
    EXPECT_TRUE(parse_target(many));
    EXPECT_FALSE(parse_target(many + "last=1"));
}

TEST(Target, SegmentsKeepEmptyOnesSoThatTwoSlashesAreNotOne) {
    EXPECT_TRUE(segments_of("/").empty());
    EXPECT_EQ(segments_of("/a/b"), (std::vector<std::string_view>{"a", "b"}));
    EXPECT_EQ(segments_of("/a//b/"), (std::vector<std::string_view>{"a", "", "b", ""}));
}

}  // namespace
}  // namespace camrig::http
