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

    /// Those of one time are kept in the order in which they came. resource_exhausted: too many wait, and `command` is
    /// as it was.
    Result<void> add(TimeNs at_ns, Command& command);
    bool empty() const { return waiting_.empty(); }
    std::size_t size() const { return waiting_.size(); }
    /// Of the first that waits; max_time_ns: none does.
    TimeNs next_ns() const { return waiting_.empty() ? max_time_ns : waiting_.begin()->first; }
    /// The first one goes.
    Command take();
    /// They go, and are answered with this.
    void refuse_all(const Error& why);

    TimeNs limit_ns() const { return limit_ns_; }
    void set_limit(TimeNs world_ns) { limit_ns_ = world_ns; }
    /// World time may go so far before something has to be done here.
    TimeNs gate_ns() const { return std::min(limit_ns_, next_ns()); }

    /// Takes note of what was done, for the digest of the rig.
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
