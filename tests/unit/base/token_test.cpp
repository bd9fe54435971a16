#include "core/base/token.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>

#include "tests/temporary_folder.h"

namespace camrig {
namespace {

TEST(Token, SurvivesUrlHeaderAndCookie) {
    EXPECT_TRUE(check_token("0123456789abcdefABCDEF+/=-._~"));
    for (const std::string bad :
         {"", "short", "with space", "semi;colon", "quote\"d123", "line\nend123", "\xc3\xbcnicode12"})
        EXPECT_FALSE(check_token(bad)) << bad;
    EXPECT_FALSE(check_token(std::string(1000, 'a')));
}

TEST(Token, TheFilesOneLineIsTheToken) {
    const TemporaryFolder folder;
    const auto file = folder / "token";
    const auto read = [&](const std::string& content) {
        std::ofstream(file, std::ios::binary) << content;
        return read_token_file(file);
    };
    EXPECT_EQ(read("secret-token\n").value(), "secret-token");
    EXPECT_EQ(read("secret-token").value(), "secret-token");
    EXPECT_FALSE(read("short\n"));
    EXPECT_FALSE(read(""));
    EXPECT_FALSE(read("two lines\nof text"));
    EXPECT_FALSE(read(std::string(300, 'a')));
    std::filesystem::remove(file);
    EXPECT_THAT(read_token_file(file).error().message, testing::HasSubstr(file.string()));
}

TEST(Token, OnlyTheSameTokenIsEqual) {
    EXPECT_TRUE(equal_tokens("secret-token", "secret-token"));
    for (const char* wrong : {"", "secret-toke", "secret-tokenx", "Secret-token", "secret-tokensecret-token"})
        EXPECT_FALSE(equal_tokens(wrong, "secret-token")) << wrong;
    EXPECT_FALSE(equal_tokens("x", ""));
    // Repetition must not look equal: the guess is compared modulo the token's length.
    EXPECT_FALSE(equal_tokens("abab", "ab"));
}

}  // namespace
}  // namespace camrig
