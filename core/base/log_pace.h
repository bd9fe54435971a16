#pragma once

#include <optional>
#include <utility>

#include "core/base/time.h"

namespace camrig {

/// Lets one log line a second through. One thread.
class LogPace {
public:
    /// How many lines were left out since the last one, if a line may be written now.
    std::optional<int> due(TimeNs now_ns) {
        if (last_ns_ != 0 && now_ns - last_ns_ < ns_per_s) {
            ++left_out_;
            return std::nullopt;
        }
        last_ns_ = now_ns;
        return std::exchange(left_out_, 0);
    }

private:
    TimeNs last_ns_ = 0;
    int left_out_ = 0;
};

}  // namespace camrig
