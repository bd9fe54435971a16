#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/base/clock.h"
#include "core/base/connection_counts.h"

namespace camrig::cli {

/// What server.info tells of this process; filled while clients may be asking already. Any thread.
class ServerFacts {
public:
    void add(std::string key, nlohmann::json value) {
        std::lock_guard lock(mutex_);
        facts_[std::move(key)] = std::move(value);
    }
    /// Asked each time; `counts` must work for as long as anybody may ask.
    void add_connections(std::string server, std::function<ConnectionCounts()> counts) {
        std::lock_guard lock(mutex_);
        connections_[std::move(server)] = std::move(counts);
    }
    nlohmann::json get() const {
        std::lock_guard lock(mutex_);
        nlohmann::json facts = facts_;
        for (const auto& [server, counts_of] : connections_) {
            const ConnectionCounts counts = counts_of();
            facts["connections"][server] = {{"open", counts.open},
                                            {"total", counts.total},
                                            {"refused", counts.refused},
                                            {"displaced", counts.displaced},
                                            {"wrong_tokens", counts.wrong_tokens}};
        }
        facts["uptime_s"] = static_cast<double>(monotonic_now_ns() - started_ns_) / 1e9;
        return facts;
    }

private:
    const TimeNs started_ns_ = monotonic_now_ns();
    mutable std::mutex mutex_;
    nlohmann::json facts_ = nlohmann::json::object();
    std::map<std::string, std::function<ConnectionCounts()>> connections_;
};

}  // namespace camrig::cli
