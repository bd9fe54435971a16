#pragma once

#include <map>
#include <optional>

#include "core/base/digest.h"
#include "core/engine/command.h"

namespace camrig::engine {

/// Commands that wait for their world time, and how far the world may run. Engine's thread.
class Agenda {
public:
    static constexpr std::size_t max_waiting = 4096;
    static constexpr TimeNs max_ahead_ns = 3600 * ns_per_s;

    /// Moves the command here until world time at_ns; commands of one time keep the order in which they came.
    /// resource_exhausted: too many wait, and `command` is unchanged.
    Result<void> add(TimeNs at_ns, Command& command);
    bool empty() const { return waiting_.empty(); }
    std::size_t size() const { return waiting_.size(); }
    /// World time of the first waiting command; max_time_ns: none waits.
    TimeNs next_ns() const { return waiting_.empty() ? max_time_ns : waiting_.begin()->first; }
    /// Removes and returns the first waiting command.
    Command take();
    /// Removes all waiting commands and answers them with this error.
    void refuse_all(const Error& why);

    /// World time beyond which the world may not run (SetLimit).
    TimeNs limit_ns() const { return limit_ns_; }
    void set_limit(TimeNs world_ns) { limit_ns_ = world_ns; }
    /// How far world time may run before a command is due or the limit is reached.
    TimeNs gate_ns() const { return std::min(limit_ns_, next_ns()); }

    /// Adds a command that was carried out to the digest (GetDigest).
    void note(TimeNs at_ns, const std::string& text) {
        ++done_;
        digest_.add(at_ns, std::string_view(text));
    }
    std::uint64_t done() const { return done_; }
    std::uint64_t digest() const { return digest_.value(); }

private:
    std::multimap<TimeNs, Command> waiting_;
    TimeNs limit_ns_ = max_time_ns;
    std::uint64_t done_ = 0;
    Digest digest_;
};

}  // namespace camrig::engine
