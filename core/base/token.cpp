#include "core/base/token.h"

#include <fstream>
#include <iterator>

namespace camrig {
namespace {

constexpr std::size_t min_token_length = 8;
constexpr std::size_t max_token_length = 256;
constexpr std::string_view token_characters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._~+/=";

}  // namespace

Result<void> check_token(std::string_view token) {
    if (token.size() >= min_token_length && token.size() <= max_token_length &&
        token.find_first_not_of(token_characters) == std::string_view::npos)
        return {};
    return error(ErrorKind::invalid_argument,
                 "token: use " + std::to_string(min_token_length) + " to " + std::to_string(max_token_length) +
                     " letters, digits and - . _ ~ + / = without spaces (e.g. from: openssl rand -hex 24)");
}

Result<std::string> read_token_file(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::string token(max_token_length + 3, '\0');
    stream.read(token.data(), static_cast<std::streamsize>(token.size()));
    if (stream.bad() || (stream.gcount() == 0 && !stream.eof()))
        return error(ErrorKind::unavailable, file.string() + ": cannot be read; it must hold the token");
    token.resize(static_cast<std::size_t>(stream.gcount()));
    while (!token.empty() && (token.back() == '\n' || token.back() == '\r')) token.pop_back();
    if (auto good = check_token(token); !good) return at(file.string(), good.error());
    return token;
}

bool equal_tokens(std::string_view given, std::string_view expected) {
    // volatile: the compiler must not find the early exit that we leave out.
    volatile unsigned difference = given.size() == expected.size() ? 0U : 1U;
    for (std::size_t i = 0; i < given.size(); ++i) {
        const char wanted = expected.empty() ? '\0' : expected[i % expected.size()];
        difference = difference | (static_cast<unsigned char>(given[i]) ^ static_cast<unsigned char>(wanted));
    }
    return difference == 0;
}

}  // namespace camrig
