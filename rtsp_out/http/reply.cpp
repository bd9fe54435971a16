#include "rtsp_out/http/reply.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace camrig::http {
namespace {

constexpr std::string_view reason_of(int status) {
    constexpr std::pair<int, std::string_view> known[] = {
        {200, "OK"},
        {204, "No Content"},
        {304, "Not Modified"},
        {400, "Bad Request"},
        {401, "Unauthorized"},
        {403, "Forbidden"},
        {404, "Not Found"},
        {405, "Method Not Allowed"},
        {409, "Conflict"},
        {413, "Content Too Large"},
        {414, "URI Too Long"},
        {415, "Unsupported Media Type"},
        {431, "Request Header Fields Too Large"},
        {501, "Not Implemented"},
        {503, "Service Unavailable"},
    };
    for (const auto& [number, reason] : known)
        if (number == status) return reason;
    return "Internal Server Error";
}

/// The time of day that the camera's clock has, in seconds since 1970 with microseconds, as mjpg-streamer writes it.
std::string unix_time_of(const frame::FrameInfo& info, TimeNs wall_offset_ns) {
    const TimeNs utc_ns = wall_offset_ns + info.monotonic_ns + info.stamp_ns() - info.world_ns;
    const std::string sign = utc_ns < 0 ? "-" : "", us = std::to_string(std::abs(utc_ns) % ns_per_s / ns_per_us);
    return sign + std::to_string(std::abs(utc_ns) / ns_per_s) + "." + std::string(6 - us.size(), '0') + us;
}

}  // namespace

std::size_t Reply::body_bytes() const {
    std::size_t bytes = text.size() + data.size();
    for (const auto& piece : pieces) bytes += piece.size();
    return bytes;
}

int status_of(ErrorKind kind) {
    switch (kind) {
        case ErrorKind::invalid_argument:
            return 400;
        case ErrorKind::not_found:
            return 404;
        case ErrorKind::already_exists:
            return 409;
        case ErrorKind::unavailable:
            return 503;
        case ErrorKind::unsupported:
            return 501;
        case ErrorKind::resource_exhausted:
            return 503;
        case ErrorKind::unauthorized:
            return 401;
        case ErrorKind::internal:
            return 500;
    }
    return 500;
}

Reply text_reply(std::string content_type, std::string text) {
    Reply reply;
    reply.content_type = std::move(content_type);
    reply.text = std::move(text);
    return reply;
}

Reply json_reply(std::string text) {
    return text_reply("application/json", std::move(text));
}

Reply error_reply(const Error& error, int status) {
    // A message may quote what a client sent; bytes that are not UTF-8 are replaced, not thrown on.
    const nlohmann::json body = {{"error", {{"kind", std::string(to_string(error.kind))}, {"message", error.message}}}};
    Reply reply = json_reply(body.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
    reply.status = status != 0 ? status : status_of(error.kind);
    if (reply.status == 401) reply.fields.emplace_back("WWW-Authenticate", "Bearer realm=\"camrig\"");
    if (reply.status == 503) reply.fields.emplace_back("Retry-After", "1");
    return reply;
}

std::string head_of(const Reply& reply, unsigned version, bool keep_alive) {
    std::string head = version == 10 ? "HTTP/1.0 " : "HTTP/1.1 ";
    head += std::to_string(reply.status);
    head += ' ';
    head += reason_of(reply.status);
    head += "\r\nServer: camrig\r\nX-Content-Type-Options: nosniff\r\n";
    const auto field = [&head](std::string_view name, std::string_view value) {
        head.append(name).append(": ").append(value).append("\r\n");
    };
    // Where it is honoured, pages of other origins do not even get the bytes.
    field("Cross-Origin-Resource-Policy", reply.embeddable ? "cross-origin" : "same-origin");
    if (!reply.content_type.empty()) field("Content-Type", reply.content_type);
    if (!reply.endless && reply.status != 204 && reply.status != 304)
        field("Content-Length", std::to_string(reply.body_bytes()));
    if (std::ranges::find(reply.fields, "Cache-Control", [](const auto& f) { return f.first; }) == reply.fields.end())
        field("Cache-Control", "no-store");
    for (const auto& [name, value] : reply.fields) field(name, value);
    if (!keep_alive) field("Connection", "close");
    if (keep_alive && version == 10) field("Connection", "keep-alive");
    head += "\r\n";
    return head;
}

std::vector<std::pair<std::string, std::string>> frame_fields(const frame::FrameInfo& info, WallOffset& wall) {
    std::vector<std::pair<std::string, std::string>> fields{{"X-Sequence", std::to_string(info.sequence)},
                                                            {"X-World-Time-Ns", std::to_string(info.world_ns)},
                                                            {"X-Monotonic-Ns", std::to_string(info.monotonic_ns)}};
    if (info.clock) {
        fields.emplace_back("X-Stamp-Ns", std::to_string(info.stamp_ns()));
        fields.emplace_back("X-Timestamp", unix_time_of(info, wall.current()));
    }
    return fields;
}

std::string etag_of(const frame::FrameInfo& info, std::span<const std::byte> bytes) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return fmt::format("\"{}-{:016x}\"", info.sequence, std::hash<std::string_view>{}(text));
}

bool etag_matches(std::string_view if_none_match, std::string_view etag) {
    // Tags of ours hold no comma and no quote inside, so a plain search for the quoted tag is exact.
    return if_none_match == "*" || if_none_match.find(etag) != std::string_view::npos;
}

}  // namespace camrig::http
