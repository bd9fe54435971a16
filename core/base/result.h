#pragma once

#include <cstdint>
#include <expected>
#include <string>
#include <string_view>
#include <utility>

namespace camrig {

/// What kind of thing went wrong; the names are part of the control protocol (`error.data.kind`).
enum class ErrorKind : std::uint8_t {
    invalid_argument,
    not_found,
    already_exists,
    unavailable,
    unsupported,
    resource_exhausted,
    unauthorized,
    internal,
};

/// The protocol's name of a kind, e.g. "invalid_argument".
std::string_view to_string(ErrorKind kind);

/// Something that can happen and the user can act on. The message says what was wrong, where, and what would be right.
struct Error {
    ErrorKind kind = ErrorKind::internal;
    std::string message;
};

template <typename T>
using Result = std::expected<T, Error>;

/// `return error(ErrorKind::not_found, "...")` from any function that returns a Result.
[[nodiscard]] inline std::unexpected<Error> error(ErrorKind kind, std::string message) {
    return std::unexpected<Error>(Error{kind, std::move(message)});
}

/// The most frequent of them: what was given is wrong.
[[nodiscard]] inline std::unexpected<Error> invalid(std::string message) {
    return error(ErrorKind::invalid_argument, std::move(message));
}

/// Hands an error on, with the place in front: `at(path, result.error())` -> "scenes/x.json: ...".
[[nodiscard]] inline std::unexpected<Error> at(std::string_view place, Error inner) {
    inner.message.insert(0, std::string(place) + ": ");
    return std::unexpected<Error>(std::move(inner));
}

namespace detail {
[[noreturn]] void check_failed(const char* condition, const char* file, int line);
}

}  // namespace camrig

/// Our own bug if it does not hold; on in release builds. Never for input.
#define CHECK(condition) \
    ((condition) ? static_cast<void>(0) : ::camrig::detail::check_failed(#condition, __FILE__, __LINE__))
