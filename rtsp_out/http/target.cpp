#include "rtsp_out/http/target.h"

#include <algorithm>

namespace camrig {
namespace {

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

bool is_printable(char c) {
    return c >= 0x20 && c <= 0x7e;
}

/// Undoes %XX. Decoded bytes outside printable ASCII (NUL, line ends, UTF-8) name nothing that exists here.
Result<std::string> percent_decode(std::string_view text, std::string_view what, bool slash_allowed) {
    std::string out;
    out.reserve(text.size());
    for (std::size_t i = 0; i < text.size(); ++i) {
        char c = text[i];
        if (c == ' ') return error(ErrorKind::invalid_argument, std::string(what) + ": a space must be written as %20");
        if (c == '%') {
            const int high = i + 1 < text.size() ? hex_digit(text[i + 1]) : -1;
            const int low = i + 2 < text.size() ? hex_digit(text[i + 2]) : -1;
            if (high < 0 || low < 0)
                return error(ErrorKind::invalid_argument,
                             std::string(what) + ": '%' must be followed by two hexadecimal digits");
            c = static_cast<char>(high * 16 + low);
            i += 2;
            if (c == '/' && !slash_allowed)
                return error(ErrorKind::invalid_argument, std::string(what) + ": an encoded '/' is not allowed");
        }
        if (!is_printable(c))
            return error(ErrorKind::invalid_argument, std::string(what) + ": only printable ASCII is allowed");
        out += c;
    }
    return out;
}

Result<std::string> parse_path(std::string_view raw) {
    auto path = percent_decode(raw, "path", false);
    if (!path) return path;
    for (const std::string_view segment : segments_of(*path)) {
        if (segment == "." || segment == "..")
            return error(ErrorKind::invalid_argument, "path: '.' and '..' are not allowed");
        if (segment.find('\\') != std::string_view::npos)
            return error(ErrorKind::invalid_argument, "path: '\\' is not allowed");
    }
    return path;
}

Result<void> parse_query(std::string_view raw, Target& target) {
    while (!raw.empty()) {
        const std::size_t end = raw.find('&');
        const std::string_view pair = raw.substr(0, end);
        raw.remove_prefix(end == std::string_view::npos ? raw.size() : end + 1);
        if (pair.empty()) continue;
        if (target.query.size() == max_query_parameters)
            return error(ErrorKind::invalid_argument,
                         "query: more than " + std::to_string(max_query_parameters) + " parameters");
        const std::size_t equals = pair.find('=');
        auto name = percent_decode(pair.substr(0, equals), "query", true);
        if (!name) return std::unexpected(name.error());
        auto value = percent_decode(equals == std::string_view::npos ? std::string_view() : pair.substr(equals + 1),
                                    "query", true);
        if (!value) return std::unexpected(value.error());
        if (target.find(*name) != nullptr)
            return error(ErrorKind::invalid_argument, "query: parameter '" + *name + "' is given twice");
        target.query.emplace_back(std::move(*name), std::move(*value));
    }
    return {};
}

}  // namespace

const std::string* Target::find(std::string_view name) const {
    const auto found = std::ranges::find_if(query, [&](const auto& entry) { return entry.first == name; });
    return found == query.end() ? nullptr : &found->second;
}

bool is_host_field(std::string_view text) {
    constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._~";
    std::string_view allowed = letters;
    std::size_t end = std::min(text.find(':'), text.size());
    if (text.starts_with('[')) {
        allowed = "0123456789abcdefABCDEF:.";
        end = text.find(']');
        if (end == std::string_view::npos) return false;
    }
    const bool is_v6 = text.starts_with('[');
    const std::string_view name = is_v6 ? text.substr(1, end - 1) : text.substr(0, end);
    std::string_view port = text.substr(is_v6 ? end + 1 : end);
    if (name.empty() || name.find_first_not_of(allowed) != std::string_view::npos) return false;
    if (port.empty()) return true;
    if (port.front() != ':') return false;
    port.remove_prefix(1);
    return port.size() <= 5 && port.find_first_not_of("0123456789") == std::string_view::npos;
}

std::vector<std::string_view> segments_of(std::string_view path) {
    std::vector<std::string_view> segments;
    if (path == "/") return segments;
    while (!path.empty()) {
        path.remove_prefix(1);  // the slash
        const std::size_t end = std::min(path.find('/'), path.size());
        segments.push_back(path.substr(0, end));
        path.remove_prefix(end);
    }
    return segments;
}

Result<Target> parse_target(std::string_view text) {
    if (text.size() > max_target_length)
        return error(ErrorKind::invalid_argument,
                     "request target: longer than " + std::to_string(max_target_length) + " bytes");
    if (text == "*") return Target{"*", {}};
    for (const std::string_view scheme : {"http://", "https://"}) {
        if (!text.starts_with(scheme)) continue;
        const std::size_t end = std::min(text.find_first_of("/?#", scheme.size()), text.size());
        if (end == scheme.size())
            return error(ErrorKind::invalid_argument, "request target: no host after " + std::string(scheme));
        text.remove_prefix(end);
        break;
    }
    // A fragment is the client's own business; one that arrives is a client's bug.
    if (text.find('#') != std::string_view::npos)
        return error(ErrorKind::invalid_argument, "request target: '#' is not allowed");
    const std::size_t mark = std::min(text.find('?'), text.size());
    std::string_view raw_path = text.substr(0, mark);
    if (raw_path.empty() && !text.empty() && text.front() == '?') raw_path = "/";
    if (raw_path.empty() || raw_path.front() != '/')
        return error(ErrorKind::invalid_argument, "request target: must begin with '/'");

    Target target;
    auto path = parse_path(raw_path);
    if (!path) return std::unexpected(path.error());
    target.path = std::move(*path);
    if (mark < text.size())
        if (auto parsed = parse_query(text.substr(mark + 1), target); !parsed) return std::unexpected(parsed.error());
    return target;
}

}  // namespace camrig
