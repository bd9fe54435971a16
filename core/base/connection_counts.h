#pragma once

#include <atomic>
#include <cstdint>

namespace camrig {

/// The connections of one server since its start.
struct ConnectionCounts {
    std::uint64_t open = 0;       ///< now
    std::uint64_t total = 0;      ///< ever taken
    std::uint64_t refused = 0;    ///< there was no place, or descriptors were short
    std::uint64_t displaced = 0;  ///< closed, while idle, for a new one
    std::uint64_t wrong_tokens = 0;
};

/// The same while the server runs; any thread.
struct LiveConnectionCounts {
    std::atomic<std::uint64_t> open{0}, total{0}, refused{0}, displaced{0}, wrong_tokens{0};

    ConnectionCounts read() const { return {open, total, refused, displaced, wrong_tokens}; }
};

}  // namespace camrig
