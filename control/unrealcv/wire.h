#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// UnrealCV's frames (Source/UnrealCV/Private/Server of its plugin, and unrealcv.SocketMessage of its client): both
/// ways a magic number and the size of what follows, 32 bits each, little-endian. A request is "ID:COMMAND", its answer
/// "ID:BODY" with the same ID, decimal; the greeting alone has none.
namespace camrig::unrealcv {

inline constexpr std::uint32_t frame_magic = 0x9E2B83C1;
inline constexpr std::size_t frame_head_bytes = 8;
/// Of one request. UnrealCV itself takes 256 MiB; commands are lines of text.
inline constexpr std::size_t max_request_bytes = std::size_t{1} << 20;

/// The head of a frame with so many bytes behind it.
std::string frame_head(std::size_t payload_bytes);

/// Cuts what a client sends into payloads. Holds one payload of max_request_bytes at most, and what was read with it.
class FrameReader {
public:
    void append(std::string_view bytes);
    /// The next payload that is there as a whole; nothing when bytes are missing or the stream is broken.
    std::optional<std::string> next();
    /// What is wrong with the stream, which cannot be read on; empty: nothing.
    const std::string& problem() const { return problem_; }

private:
    std::string bytes_;
    std::size_t begin_ = 0;  ///< of the frame that is being received
    std::string problem_;
};

struct Request {
    std::string_view id;  ///< 1 to 20 digits
    std::string_view command;
};
/// Nothing: the payload is no request, and cannot be answered.
std::optional<Request> parse_request(std::string_view payload);

}  // namespace camrig::unrealcv
