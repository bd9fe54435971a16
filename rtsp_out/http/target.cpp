#include "rtsp_out/http/target.h"

#include <algorithm>

#include "core/base/percent.h"

namespace camrig::http {
namespace {

bool is_printable(char c) {
    return c >= 0x20 && c <= 0x7e;
}

/// Undoes %XX. Decoded bytes outside printable ASCII (NUL, line ends, UTF-8) name nothing that exists here.
Result<std::string> decoded(std::string_view text, const std::string& what) {
    if (text.contains(' ')) return error(ErrorKind::invalid_argument, what + ": a space must be written as %20");
    auto out = percent_decode(text);
    if (!out) return error(ErrorKind::invalid_argument, what + ": '%' must be followed by two hexadecimal digits");
    if (!std::ranges::all_of(*out, is_printable))
        return error(ErrorKind::invalid_argument, what + ": only printable ASCII is allowed");
    return std::move(*out);
}

Result<std::string> parse_path(std::string_view raw) {
    for (const char* slash : {"%2f", "%2F"})
        if (raw.contains(slash)) return error(ErrorKind::invalid_argument, "path: an encoded '/' is not allowed");
    auto path = decoded(raw, "path");
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
        auto name = decoded(pair.substr(0, equals), "query");
        if (!name) return std::unexpected(name.error());
        auto value = decoded(equals == std::string_view::npos ? std::string_view() : pair.substr(equals + 1), "query");
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

}  // namespace camrig::http
