#include "core/fault/line.h"

#include <algorithm>
#include <cmath>

namespace camrig::fault {

std::optional<LineRate> line_rate(const FrameFaults& faults, std::string_view output) {
    std::optional<LineRate> slowest;
    for (const FaultRef& one : faults.active) {
        const auto* const how = std::get_if<Bandwidth>(&one->kind);
        if (!how || !is_for(how->output, output)) continue;
        const LineRate rate{how->kbit_per_s * 1e3 / one->severity, std::llround(how->queue_s * 1e9), one};
        if (!slowest || rate.bit_per_s < slowest->bit_per_s) slowest = rate;
    }
    return slowest;
}

bool Line::takes(const std::optional<LineRate>& rate, TimeNs now_ns, std::size_t bytes) {
    if (!rate || now_ns < last_ns_) free_ns_ = 0;
    last_ns_ = now_ns;
    if (!rate) return true;
    const TimeNs begin_ns = std::max(now_ns, free_ns_);
    if (begin_ns - now_ns > rate->queue_ns) return false;
    free_ns_ = begin_ns + std::llround(8e9 * static_cast<double>(bytes) / rate->bit_per_s);
    return true;
}

}  // namespace camrig::fault
