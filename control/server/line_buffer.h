#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace camrig::control {

/// Cuts what a peer sends into lines; looks at every byte once. Holds at most one line of `max_line` bytes and what was
/// read with it.
class LineBuffer {
public:
    explicit LineBuffer(std::size_t max_line) : max_line_(max_line) {}

    void append(std::string_view bytes);
    /// The next line without "\n" or "\r\n"; valid until the next call that changes the buffer.
    std::optional<std::string_view> next_line();
    /// True when the line that is being received is longer than allowed already.
    bool too_long() const { return text_.size() - begin_ > max_line_; }
    /// What came after the last line end.
    std::string_view rest() const { return std::string_view(text_).substr(begin_); }
    void set_max_line(std::size_t max_line) { max_line_ = max_line; }

private:
    std::size_t max_line_;
    std::string text_;
    std::size_t begin_ = 0;    ///< of the line that is being received
    std::size_t scanned_ = 0;  ///< no line end before this
};

}  // namespace camrig::control
