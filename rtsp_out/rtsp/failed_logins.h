#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "core/base/time.h"

namespace camrig::rtsp {

/// Counts failed authentications per client address, to slow down guessing. Plain arithmetic, bounded memory.
class FailedLogins {
public:
    static constexpr int free_failures = 5;             ///< so many do not count: typing errors
    static constexpr TimeNs memory_ns = 60 * ns_per_s;  ///< an address starts anew after so long without a failure
    static constexpr std::size_t max_addresses = 1024;

    void add(const std::string& address, TimeNs now_ns) {
        if (failures_.size() >= max_addresses && !failures_.contains(address)) forget(now_ns);
        Failures& of_address = failures_[address];
        if (now_ns - of_address.last_ns > memory_ns) of_address.count = 0;
        ++of_address.count;
        of_address.last_ns = now_ns;
    }
    /// Whether new connections of this address are to be left unread for a while (RtspListener::wait_ns).
    bool must_wait(const std::string& address, TimeNs now_ns) const {
        const auto found = failures_.find(address);
        return found != failures_.end() && found->second.count > free_failures &&
               now_ns - found->second.last_ns <= memory_ns;
    }

private:
    struct Failures {
        int count = 0;
        TimeNs last_ns = 0;
    };
    /// Forgets old entries, or all where none is old: an attacker with so many addresses is not slowed anyway.
    void forget(TimeNs now_ns) {
        std::erase_if(failures_, [&](const auto& known) { return now_ns - known.second.last_ns > memory_ns; });
        if (failures_.size() >= max_addresses) failures_.clear();
    }

    std::map<std::string, Failures> failures_;
};

}  // namespace camrig::rtsp
