#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "tools/view/rig_model.h"

namespace camrig::view {

/// What an actor did from one world time to another, as far as it was seen.
struct Doing {
    std::int64_t from_ns = 0;
    std::int64_t to_ns = 0;
    std::string what;
};

/// What actors did and which events fired in the last span of world time. Begins anew when world time goes back.
class Timeline {
public:
    void update(const RigModel& model);

    const std::map<std::string, std::deque<Doing>>& actors() const { return actors_; }
    std::int64_t now_ns() const { return now_ns_; }

    static constexpr std::int64_t span_ns = 60'000'000'000;

private:
    std::int64_t now_ns_ = 0;
    std::map<std::string, std::deque<Doing>> actors_;
};

}  // namespace camrig::view
