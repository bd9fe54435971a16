#include "rtsp_out/rtsp/request_bounds.h"

#include <algorithm>
#include <charconv>

namespace camrig::rtsp {
namespace {

constexpr std::string_view token_marks = "!#$%&'*+-.^_`|~";  // RFC 9110, 5.6.2

std::unexpected<Error> broken(std::string rule) {
    return error(ErrorKind::invalid_argument, std::move(rule));
}

bool is_token(std::string_view text) {
    return !text.empty() && std::ranges::all_of(text, [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               token_marks.find(c) != std::string_view::npos;
    });
}

bool is_text(char c) {
    const auto code = static_cast<unsigned char>(c);
    return c == '\t' || (code >= 0x20 && code != 0x7f);
}

bool equal_ignoring_case(std::string_view a, std::string_view b) {
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; };
    return std::ranges::equal(a, b, {}, lower, lower);
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
    while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    return text;
}

}  // namespace

Result<void> RequestBounds::take(std::string_view bytes, TimeNs monotonic_ns) {
    while (!bytes.empty()) {
        if (state_ == State::body) {
            const std::size_t passed = std::min(left_, bytes.size());
            bytes.remove_prefix(passed);
            if ((left_ -= passed) == 0) end_message();
            continue;
        }
        if (auto good = take_byte(bytes.front(), monotonic_ns); !good) return good;
        bytes.remove_prefix(1);
    }
    return {};
}

Result<void> RequestBounds::take_byte(char byte, TimeNs now_ns) {
    if (state_ == State::data_head) {  // channel, then two bytes of length
        if (left_ <= 2) body_bytes_ = body_bytes_ << 8 | static_cast<unsigned char>(byte);
        if (--left_ > 0) return {};
        if (body_bytes_ > limits_.data_bytes)
            return broken("an interleaved packet of " + std::to_string(body_bytes_) + " bytes");
        left_ = body_bytes_;
        state_ = State::body;
        if (left_ == 0) end_message();
        return {};
    }
    if (++head_bytes_ > limits_.head_bytes)
        return broken("a head of more than " + std::to_string(limits_.head_bytes) + " bytes");
    switch (state_) {
        case State::between:
            return begin(byte, now_ns);
        case State::line_end:
            return byte == '\n' ? end_line() : broken("a line that does not end in CR LF");
        default:
            break;
    }
    if (byte == '\r') {
        state_ = State::line_end;
        return {};
    }
    if (!is_text(byte)) return broken("a control character, or a line that does not end in CR LF");
    if (line_.size() >= limits_.line_bytes)
        return broken("a line of more than " + std::to_string(limits_.line_bytes) + " bytes");
    line_.push_back(byte);
    return {};
}

Result<void> RequestBounds::begin(char byte, TimeNs now_ns) {
    if (byte == '\r' || byte == '\n') return {};  // between messages, up to the bound of a head
    if (now_ns - second_began_ns_ >= ns_per_s) {
        second_began_ns_ = now_ns;
        messages_in_second_ = 0;
    }
    if (++messages_in_second_ > limits_.messages_per_s)
        return broken("more than " + std::to_string(limits_.messages_per_s) + " messages a second");
    began_ns_ = now_ns;
    if (byte == '$') {
        if (!may_send_data_) return broken("an interleaved packet without a stream");
        state_ = State::data_head;
        left_ = 3;
        return {};
    }
    state_ = State::line;
    --head_bytes_;
    return take_byte(byte, now_ns);
}

Result<void> RequestBounds::end_line() {
    state_ = State::line;
    if (line_.empty()) {  // the end of the head
        left_ = body_bytes_;
        state_ = State::body;
        if (left_ == 0) end_message();
        return {};
    }
    if (++lines_ > limits_.header_lines + 1)
        return broken("more than " + std::to_string(limits_.header_lines) + " header lines");
    auto good = lines_ == 1 ? check_request_line() : read_field();
    line_.clear();
    return good;
}

Result<void> RequestBounds::check_request_line() const {
    const std::string_view line = line_;
    const auto method_end = line.find(' ');
    const auto version = line.rfind(' ') + 1;
    const bool has_three_words = method_end != std::string_view::npos && version > method_end + 1;
    if (line.starts_with("RTSP") || line.starts_with("HTTP") || !has_three_words ||
        !is_token(line.substr(0, method_end)) || !line.substr(version).starts_with("RTSP/"))
        return broken("no RTSP request");
    return {};
}

Result<void> RequestBounds::read_field() {
    const std::string_view line = line_;
    const auto colon = line.find(':');
    if (colon == std::string_view::npos || !is_token(line.substr(0, colon)))
        return broken("a line that is no header field");
    if (!equal_ignoring_case(line.substr(0, colon), "Content-Length")) return {};
    const std::string_view number = trimmed(line.substr(colon + 1));
    const auto read = std::from_chars(number.data(), number.data() + number.size(), body_bytes_);
    if (std::exchange(has_length_, true) || read.ec != std::errc() || read.ptr != number.data() + number.size())
        return broken("a Content-Length that is no number, or a second one");
    if (body_bytes_ > limits_.body_bytes)
        return broken("a body of more than " + std::to_string(limits_.body_bytes) + " bytes");
    return {};
}

void RequestBounds::end_message() {
    state_ = State::between;
    line_.clear();
    lines_ = head_bytes_ = left_ = body_bytes_ = 0;
    has_length_ = false;
    began_ns_ = 0;
}

}  // namespace camrig::rtsp
