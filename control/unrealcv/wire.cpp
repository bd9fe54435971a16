#include "control/unrealcv/wire.h"

#include <algorithm>

namespace camrig::unrealcv {
namespace {

constexpr std::size_t max_id_digits = 20;

std::uint32_t read_u32(std::string_view bytes) {
    std::uint32_t value = 0;
    for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
    return value;
}

void append_u32(std::string& out, std::uint32_t value) {
    for (int i = 0; i < 4; ++i) out.push_back(static_cast<char>(value >> (8 * i) & 0xffU));
}

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

}  // namespace

std::string frame_head(std::size_t payload_bytes) {
    std::string head;
    append_u32(head, frame_magic);
    append_u32(head, static_cast<std::uint32_t>(payload_bytes));
    return head;
}

void FrameReader::append(std::string_view bytes) {
    if (!problem_.empty()) return;
    if (begin_ == bytes_.size()) {
        bytes_.clear();
        begin_ = 0;
    } else if (begin_ >= max_request_bytes) {
        bytes_.erase(0, begin_);
        begin_ = 0;
    }
    bytes_.append(bytes);
}

std::optional<std::string> FrameReader::next() {
    const std::string_view rest = std::string_view(bytes_).substr(begin_);
    if (!problem_.empty() || rest.size() < frame_head_bytes) return std::nullopt;
    const std::size_t size = read_u32(rest.substr(4));
    if (read_u32(rest) != frame_magic)
        problem_ = "a frame begins with a wrong magic number";
    else if (size == 0)
        problem_ = "a frame is empty";
    else if (size > max_request_bytes)
        problem_ =
            "a frame of " + std::to_string(size) + " bytes; requests have at most " + std::to_string(max_request_bytes);
    if (!problem_.empty()) {
        bytes_ = {};
        begin_ = 0;
        return std::nullopt;
    }
    if (rest.size() < frame_head_bytes + size) return std::nullopt;
    begin_ += frame_head_bytes + size;
    return std::string(rest.substr(frame_head_bytes, size));
}

std::optional<Request> parse_request(std::string_view payload) {
    const std::size_t colon = payload.find(':');
    if (colon == 0 || colon > max_id_digits || !std::ranges::all_of(payload.substr(0, colon), is_digit))
        return std::nullopt;
    return Request{payload.substr(0, colon), payload.substr(colon + 1)};
}

}  // namespace camrig::unrealcv
