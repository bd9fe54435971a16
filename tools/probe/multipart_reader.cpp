#include "tools/probe/multipart_reader.h"

#include <algorithm>
#include <charconv>

namespace camrig::probe {
namespace {

std::string lower(std::string_view text) {
    std::string result(text);
    std::ranges::transform(result, result.begin(),
                           [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return result;
}

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view blanks = " \t\r\"";
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
    return text.substr(0, text.find_last_not_of(blanks) + 1);
}

Error broken(const std::string& what) {
    return {ErrorKind::unavailable, "the stream breaks the multipart format: " + what};
}

}  // namespace

std::optional<std::int64_t> BodyPart::number(const std::string& field) const {
    const auto found = fields.find(field);
    if (found == fields.end()) return std::nullopt;
    std::int64_t value = 0;
    const char* const end = found->second.data() + found->second.size();
    const auto [stop, failed] = std::from_chars(found->second.data(), end, value);
    return failed == std::errc() && stop == end ? std::optional(value) : std::nullopt;
}

Result<MultipartReader> MultipartReader::create(std::string_view content_type) {
    const std::string type = lower(content_type);
    const std::size_t at = type.find("boundary=");
    if (!type.starts_with("multipart/") || at == std::string::npos) {
        return error(ErrorKind::invalid_argument, "is no MJPEG stream but '" + std::string(content_type.substr(0, 60)) +
                                                      "'; a stream is multipart/x-mixed-replace");
    }
    std::string_view boundary = content_type.substr(at + 9);
    boundary = trimmed(boundary.substr(0, boundary.find(';')));
    // Some servers write the dashes of the delimiter into the header too.
    while (boundary.starts_with("--")) boundary.remove_prefix(2);
    if (boundary.empty()) return error(ErrorKind::invalid_argument, "the answer's boundary is empty");
    return MultipartReader("--" + std::string(boundary));
}

Result<std::optional<BodyPart>> MultipartReader::next() {
    if (!part_) {
        const auto ready = read_head();
        if (!ready) return std::unexpected(ready.error());
        if (!*ready) return std::nullopt;
    }
    std::size_t length = 0, skip = 0;
    if (const auto given = part_->number("content-length")) {
        if (*given < 0 || static_cast<std::size_t>(*given) > max_part_bytes)
            return std::unexpected(broken("Content-Length " + std::to_string(*given)));
        length = static_cast<std::size_t>(*given);
        if (pending_.size() < length) return std::nullopt;
    } else {
        const std::size_t end = pending_.find("\r\n" + delimiter_);
        if (end == std::string::npos) {
            if (pending_.size() > max_part_bytes) return std::unexpected(broken("a part without an end"));
            return std::nullopt;
        }
        length = end;
        skip = 2;
    }
    part_->bytes = pending_.substr(0, length);
    pending_.erase(0, length + skip);
    return std::exchange(part_, std::nullopt);
}

/// True when part_ holds the next part's fields and pending_ begins with its bytes.
Result<bool> MultipartReader::read_head() {
    const std::size_t begin = pending_.find(delimiter_);
    const std::size_t end = begin == std::string::npos ? begin : pending_.find("\r\n\r\n", begin);
    if (end == std::string::npos) {
        if (pending_.size() > max_head_bytes) return std::unexpected(broken("no boundary, or a part without a head"));
        return false;
    }
    BodyPart part;
    std::string_view head = std::string_view(pending_).substr(begin, end - begin);
    head.remove_prefix(std::min(head.find("\r\n"), head.size()));
    while (head.starts_with("\r\n")) {
        head.remove_prefix(2);
        const std::string_view line = head.substr(0, head.find("\r\n"));
        head.remove_prefix(line.size());
        const std::size_t colon = line.find(':');
        if (colon == std::string_view::npos) continue;
        part.fields[lower(trimmed(line.substr(0, colon)))] = trimmed(line.substr(colon + 1));
    }
    pending_.erase(0, end + 4);
    part_ = std::move(part);
    return true;
}

}  // namespace camrig::probe
