#include "rtsp_out/http/asking_page.h"

#include <vector>

#include <gtest/gtest.h>

namespace camrig::http {
namespace {

constexpr std::string_view our_host = "127.0.0.1:8080";

TEST(AskingPage, ProgramsAndTheRigsOwnPageAreNotAskedWhoTheyAre) {
    EXPECT_TRUE(check_page({.host = our_host, .origin = {}, .referer = {}, .sec_fetch_site = {}}));
    EXPECT_TRUE(check_page({.host = {}, .origin = {}, .referer = {}, .sec_fetch_site = {}}));
    EXPECT_TRUE(check_page({.host = our_host, .origin = {}, .referer = {}, .sec_fetch_site = "same-origin"}));
    EXPECT_TRUE(check_page({.host = our_host, .origin = {}, .referer = {}, .sec_fetch_site = "none"}));
    EXPECT_TRUE(check_page({.host = our_host, .origin = "http://127.0.0.1:8080", .referer = {}, .sec_fetch_site = {}}));
    EXPECT_TRUE(
        check_page({.host = our_host, .origin = {}, .referer = "http://127.0.0.1:8080/?x=1", .sec_fetch_site = {}}));
}

TEST(AskingPage, PagesOfOtherOriginsAreRefusedByWhicheverFieldTellsThem) {
    for (const char* site : {"cross-site", "same-site", "", "x"})
        EXPECT_FALSE(check_page({.host = our_host, .origin = {}, .referer = {}, .sec_fetch_site = site})) << site;
    for (const char* origin : {"http://evil.example", "http://127.0.0.1:9000", "null", "", "127.0.0.1:8080",
                               "http://127.0.0.1:8080.evil.example"})
        EXPECT_FALSE(check_page({.host = our_host, .origin = origin, .referer = {}, .sec_fetch_site = {}})) << origin;
    for (const char* page : {"http://evil.example/x", "http://127.0.0.1:9000/127.0.0.1:8080", "about:blank", "",
                             "http://x@127.0.0.1:8080/"})
        EXPECT_FALSE(check_page({.host = our_host, .origin = {}, .referer = page, .sec_fetch_site = {}})) << page;
}

TEST(AskingPage, ListedPagesAreKnownByOriginOrReferer) {
    const std::vector<std::string> listed{"https://dash.example", "http://localhost:3000"};
    EXPECT_TRUE(is_listed_page(
        {.host = our_host, .origin = {}, .referer = "http://localhost:3000/rig", .sec_fetch_site = "cross-site"},
        listed));
    EXPECT_TRUE(is_listed_page(
        {.host = our_host, .origin = "https://dash.example", .referer = {}, .sec_fetch_site = {}}, listed));
    for (const char* other : {"http://dash.example", "https://dash.example.evil", "https://dash.example:1", "null", ""})
        EXPECT_FALSE(is_listed_page({.host = our_host, .origin = other, .referer = {}, .sec_fetch_site = {}}, listed));
    EXPECT_FALSE(is_listed_page({.host = our_host, .origin = {}, .referer = {}, .sec_fetch_site = {}}, listed));
}

TEST(AskingPage, AnOriginHasASchemeAndAHostAndNothingElse) {
    for (const char* good : {"http://localhost:3000", "https://dash.example", "http://[::1]:80"})
        EXPECT_TRUE(check_page_origin(good)) << good;
    for (const char* bad : {"", "*", "null", "localhost:3000", "http://", "http://a/", "http://A", "ftp://a",
                            "http://a?", "http://u@a", "http://a b"})
        EXPECT_FALSE(check_page_origin(bad)) << bad;
}

}  // namespace
}  // namespace camrig::http
