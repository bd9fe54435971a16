#include "control/server/line_buffer.h"

namespace camrig::control {
namespace {

/// An idle connection keeps no more than this.
constexpr std::size_t kept_bytes = 64 * 1024;

}  // namespace

void LineBuffer::append(std::string_view bytes) {
    if (begin_ > 0) {
        text_.erase(0, begin_);
        scanned_ -= begin_;
        begin_ = 0;
        if (text_.size() < kept_bytes && text_.capacity() > kept_bytes) text_.shrink_to_fit();
    }
    text_.append(bytes);
}

std::optional<std::string_view> LineBuffer::next_line() {
    const std::size_t end = text_.find('\n', scanned_);
    if (end == std::string::npos) {
        scanned_ = text_.size();
        return std::nullopt;
    }
    if (end - begin_ > max_line_) return std::nullopt;  // too_long() says so
    std::string_view line = std::string_view(text_).substr(begin_, end - begin_);
    begin_ = scanned_ = end + 1;
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
}

}  // namespace camrig::control
