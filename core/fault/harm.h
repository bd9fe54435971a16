#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace camrig::fault {

struct FrameFaults;

/// What a fault did to the bytes of a picture on its way: where they are wrong or missing.
struct Harm {
    static constexpr std::size_t max_runs = 64;
    struct Run {
        std::size_t offset = 0;  ///< in the picture as this fault found it
        std::size_t bytes = 0;
        friend bool operator==(const Run&, const Run&) = default;
    };

    std::uint64_t fault = 0;  ///< its number
    std::string_view kind;
    std::string_view mode;   ///< of its kind; of one that only leaves out the end, truncate
    std::size_t size = 0;    ///< bytes of the picture as this fault found it
    std::size_t bytes = 0;   ///< wrong or missing, in all
    std::size_t runs = 0;    ///< in so many runs
    std::vector<Run> first;  ///< the first of them, at most max_runs

    /// Behind all that was added before, or next to it.
    void add(std::size_t offset, std::size_t count);
    /// Adds what is different in two pictures of one size, which begin so far behind the picture's begin.
    void add_changes(std::span<const std::byte> before, std::span<const std::byte> after, std::size_t offset);
    friend bool operator==(const Harm&, const Harm&) = default;
};

/// What became of one frame's bytes, as its outputs tell while they send them. Any thread.
class HarmLog {
public:
    static constexpr std::size_t max_entries = 16;
    struct Entry {
        Harm harm;
        std::uint64_t times = 1;  ///< sent so to so many readers, RTSP streams or devices
    };
    struct Entries {
        std::vector<Entry> first;    ///< in an order of their own, whoever was sent to first; at most max_entries
        std::uint64_t left_out = 0;  ///< so often a picture was harmed otherwise than those
    };

    /// `output`: its kind, of which there are few.
    void add(std::string_view output, const Harm& harm);
    Entries entries(std::string_view output) const;

private:
    mutable std::mutex mutex_;
    std::map<std::string, Entries, std::less<>> kept_;
};

/// Notes it in the log of the frame, if there was any.
void note(const FrameFaults& faults, std::string_view output, const Harm& harm);

}  // namespace camrig::fault
