#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/base/time.h"
#include "core/fault/fault_kind.h"
#include "core/fault/harm.h"

namespace camrig::fault {

/// What is asked for.
struct FaultSpec {
    FaultKind kind = {};
    std::optional<TimeNs> begin_ns = {};     ///< world time; nullopt: when it is set
    std::optional<TimeNs> end_ns = {};       ///< world time from which it is over; nullopt: until it is cleared
    double severity = 1.0;                   ///< 0 to 1
    std::optional<std::uint64_t> seed = {};  ///< of what is random in it; nullopt: the rig's
};

/// A fault of a camera. Immutable.
struct Fault {
    std::uint64_t id = 0;  ///< unique in a rig; counts from 1
    FaultKind kind;
    TimeNs begin_ns = 0;
    TimeNs end_ns = max_time_ns;
    double severity = 1.0;
    std::uint64_t seed = 0;

    bool is_at(TimeNs world_ns) const { return begin_ns <= world_ns && world_ns < end_ns; }
};
using FaultRef = std::shared_ptr<const Fault>;

/// A frame of a camera, as faults know it: what they do to it is a function of this alone.
struct FrameKey {
    std::int64_t sequence = 0;
    TimeNs world_ns = 0;
    friend bool operator==(const FrameKey&, const FrameKey&) = default;
};

/// Uniform in [0, 1): hash(seed, fault, frame). `salt` tells several numbers of one fault and frame apart.
double chance(const Fault& fault, std::uint64_t frame, std::uint64_t salt = 0);

/// Whether a fault of these outputs is one of that kind.
bool is_for(Output wanted, std::string_view output);

/// Whether a fault that lasts for its severity's share of each period acts at that time.
bool is_in_period(const Fault& fault, TimeNs world_ns, double period_s);

/// The faults that a frame has, and what becomes of it.
struct FrameFaults {
    FrameKey frame;
    std::vector<FaultRef> active;  ///< in the order in which they act; never empty
    bool is_dropped = false;       ///< it does not come
    /// The frame whose picture it has, and where it does not come, the one whose picture was the last to be seen.
    std::int64_t shown_sequence = 0;
    std::shared_ptr<HarmLog> harms = {};  ///< what outputs tell of its bytes; null: nobody asks
};
using FrameFaultsRef = std::shared_ptr<const FrameFaults>;  ///< null: none

/// All faults of a camera: a function of world time. A value; any thread. Commands make another one of it.
class FaultPlan {
public:
    static constexpr std::size_t max_faults = 64;
    static constexpr TimeNs kept_ns = 250 * ns_per_ms;  ///< so long one that is over can still be asked for

    /// invalid_argument: it ends before it begins, or is over. unsupported: no output can do it. resource_exhausted:
    /// too many.
    Result<FaultRef> set(const FaultSpec& spec, std::uint64_t id, std::uint64_t rig_seed, TimeNs now_ns);
    /// Ends those that `is_meant(fault)`; how many.
    template <typename IsMeant>
    std::size_t clear(TimeNs now_ns, IsMeant is_meant) {
        std::size_t cleared = 0;
        for (FaultRef& one : faults_) {
            if (one->end_ns <= now_ns || !is_meant(*one)) continue;
            auto ended = std::make_shared<Fault>(*one);
            ended->end_ns = now_ns;
            one = std::move(ended);
            ++cleared;
        }
        return cleared;
    }

    bool empty() const { return faults_.empty(); }
    /// Those that are not over, in the order in which they act.
    std::vector<FaultRef> present(TimeNs now_ns) const;
    /// nullopt: none.
    std::optional<FrameFaults> at(const FrameKey& frame) const;

private:
    std::vector<FaultRef> faults_;  ///< in the order in which they act
};

}  // namespace camrig::fault
