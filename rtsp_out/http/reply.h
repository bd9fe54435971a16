#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/base/wall_offset.h"
#include "core/frame/frame.h"

namespace camrig::http {

/// One HTTP answer. The body is `text`, `data` and `pieces`, in that order; `keep` owns what `data` points to.
struct Reply {
    int status = 200;
    std::string content_type;  ///< empty: the answer has no body
    std::vector<std::pair<std::string, std::string>> fields;
    std::string text;
    std::span<const std::byte> data;
    std::vector<std::string> pieces;  ///< of the body, after `data`
    std::shared_ptr<const void> keep;
    bool close = false;       ///< close the connection after it
    bool embeddable = false;  ///< a page of another origin may show it (Cross-Origin-Resource-Policy)
    bool endless = false;     ///< no Content-Length: the body lasts until the connection closes

    std::size_t body_bytes() const;
};

/// The HTTP status for this kind of error.
int status_of(ErrorKind kind);

Reply text_reply(std::string content_type, std::string text);
Reply json_reply(std::string text);
/// `{"error":{"kind":..,"message":..}}`. Status 0: the one of the error's kind.
Reply error_reply(const Error& error, int status = 0);
inline Reply error_reply(int status, ErrorKind kind, std::string message) {
    return error_reply(Error{kind, std::move(message)}, status);
}

/// Status line and fields up to and including the empty line. `version` is 10 or 11.
std::string head_of(const Reply& reply, unsigned version, bool keep_alive);

/// The fields that say which frame a picture is: X-Sequence, X-World-Time-Ns, X-Monotonic-Ns; of a camera with a clock
/// what it shows, too: X-Stamp-Ns, X-Timestamp.
std::vector<std::pair<std::string, std::string>> frame_fields(const frame::FrameInfo& info, WallOffset& wall);

/// The entity tag of a picture: its sequence, and a digest of its bytes, for a camera that is changed in a world that
/// stands shows another picture of the same sequence.
std::string etag_of(const frame::FrameInfo& info, std::span<const std::byte> bytes);

/// True if an If-None-Match field names this tag.
bool etag_matches(std::string_view if_none_match, std::string_view etag);

}  // namespace camrig::http
