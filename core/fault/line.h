#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "core/fault/fault_plan.h"

/// Layer transport: lines that carry less than pictures need.
namespace camrig::fault {

/// What a line carries, and how long something may wait before it.
struct LineRate {
    double bit_per_s = 0.0;
    TimeNs queue_ns = 0;
    FaultRef by = {};  ///< of several faults, the one that lets it carry least
};
std::optional<LineRate> line_rate(const FrameFaults& faults, std::string_view output);
/// The line to one reader, in world time, so that a run loses the same again. Where time goes back another world was
/// loaded, and nothing waits before the line.
class Line {
public:
    /// Whether so many bytes get through that are sent at that time; nullopt: the line carries all.
    bool takes(const std::optional<LineRate>& rate, TimeNs now_ns, std::size_t bytes);

private:
    TimeNs free_ns_ = 0;  ///< it is busy until then
    TimeNs last_ns_ = 0;  ///< the last call's now_ns
};

}  // namespace camrig::fault
