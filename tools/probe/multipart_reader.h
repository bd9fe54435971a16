#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace camrig::probe {

/// One part of a multipart body: its fields, names in lower case, and its bytes.
struct BodyPart {
    std::map<std::string, std::string> fields;
    std::string bytes;

    /// A field as a whole number.
    std::optional<std::int64_t> number(const std::string& field) const;
};

/// Takes a multipart/x-mixed-replace body apart, as much of it as there is. With Content-Length a part is complete when
/// its last byte is there; without, when the next boundary is.
class MultipartReader {
public:
    static constexpr std::size_t max_part_bytes = std::size_t{64} << 20;
    static constexpr std::size_t max_head_bytes = 8192;

    /// `content_type`: of the answer. invalid_argument when it is no multipart stream.
    static Result<MultipartReader> create(std::string_view content_type);

    void feed(std::string_view bytes) { pending_ += bytes; }
    /// The next complete part; nothing: feed more. An error: the body breaks the format or its limits.
    Result<std::optional<BodyPart>> next();

private:
    explicit MultipartReader(std::string delimiter) : delimiter_(std::move(delimiter)) {}
    Result<bool> read_head();

    std::string delimiter_;  ///< "--" and the boundary
    std::string pending_;
    std::optional<BodyPart> part_;  ///< its head has been read
};

}  // namespace camrig::probe
