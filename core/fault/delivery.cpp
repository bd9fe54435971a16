#include "core/fault/delivery.h"

#include <algorithm>
#include <cmath>

namespace camrig::fault {
namespace {

/// How far back the state of Gilbert's chain is looked for; further back it was good.
constexpr std::int64_t max_look_back = 4096;

/// Gilbert's chain (E. N. Gilbert, "Capacity of a burst-noise channel", 1960) as a function of the frame: a frame whose
/// random number decides without knowing the state before it is looked for backwards. That state is the larger the
/// larger `share` is, frame by frame.
bool is_bad(const Fault& fault, double share, double burst, std::int64_t frame) {
    if (share >= 1.0) return true;
    burst = std::max(burst, 1.0 / (1.0 - share));
    const double stays_bad = 1.0 - 1.0 / burst, turns_bad = share / (burst * (1.0 - share));
    const std::int64_t first = std::max<std::int64_t>(0, frame - max_look_back);
    std::int64_t decided = frame;
    bool state = false;
    for (; decided >= first; --decided) {
        const double number = chance(fault, static_cast<std::uint64_t>(decided));
        if (number < std::min(turns_bad, stays_bad)) {
            state = true;
            break;
        }
        if (number >= std::max(turns_bad, stays_bad)) break;
    }
    // Between, each number keeps the state: it is below `stays_bad` and not below `turns_bad`.
    return state;
}

struct Drops {
    const Fault& fault;
    const FrameKey& frame;
    bool operator()(const Drop& drop) const {
        return is_bad(fault, drop.probability * fault.severity, drop.burst_frames, frame.sequence);
    }
    bool operator()(const ReducedRate& reduced) const {
        // Those come at which the count of those that come rises: again and again the same in 10^9 frames.
        constexpr std::int64_t cycle = 1'000'000'000;
        const std::int64_t kept = std::llround((1.0 - reduced.share * fault.severity) * cycle);
        const std::int64_t index = frame.sequence % cycle;
        return (index + 1) * kept / cycle == index * kept / cycle;
    }
    bool operator()(const auto&) const { return false; }
};

struct Repeats {
    const Fault& fault;
    const FrameKey& frame;
    TimeNs shown_ns;
    bool operator()(const Freeze& freeze) const {
        TimeNs since_ns = fault.begin_ns;
        if (fault.severity < 1.0) {
            const TimeNs period_ns = std::llround(freeze.period_s * 1e9);
            const TimeNs phase_ns = (frame.world_ns - fault.begin_ns) % period_ns;
            if (static_cast<double>(phase_ns) >= fault.severity * static_cast<double>(period_ns)) return false;
            since_ns = frame.world_ns - phase_ns;
        }
        return shown_ns >= since_ns;
    }
    bool operator()(const Duplicate& duplicate) const {
        return chance(fault, static_cast<std::uint64_t>(frame.sequence)) < duplicate.probability * fault.severity;
    }
    bool operator()(const auto&) const { return false; }
};

}  // namespace

bool is_dropped(const FrameFaults& faults) {
    return std::ranges::any_of(faults.active,
                               [&](const FaultRef& one) { return std::visit(Drops{*one, faults.frame}, one->kind); });
}

std::int64_t frames_late(const FrameFaults& faults, std::string_view output) {
    std::int64_t late = 0;
    for (const FaultRef& one : faults.active) {
        const auto* const how = std::get_if<Late>(&one->kind);
        if (!how || !is_for(how->output, output)) continue;
        const auto frames = static_cast<std::int64_t>(std::ceil(one->severity * static_cast<double>(how->frames)));
        late = std::max(late, how->in_bursts ? frames - faults.frame.sequence % (frames + 1) : frames);
    }
    return late;
}

bool is_repeat(const FrameFaults& faults, TimeNs shown_ns) {
    return std::ranges::any_of(faults.active, [&](const FaultRef& one) {
        return std::visit(Repeats{*one, faults.frame, shown_ns}, one->kind);
    });
}

}  // namespace camrig::fault
