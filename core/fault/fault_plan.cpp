#include "core/fault/fault_plan.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/base/random.h"
#include "core/fault/delivery.h"
#include "core/fault/sending.h"

namespace camrig::fault {
namespace {

/// Streams of random numbers of a rig's seed that nothing else has.
constexpr std::uint64_t fault_stream = std::uint64_t{3} << 60;
constexpr int salt_bits = 8;

auto order_of(const FaultRef& fault) {
    return std::tuple(fault->kind.index(), fault->id);
}

}  // namespace

double chance(const Fault& fault, std::uint64_t frame, std::uint64_t salt) {
    return random_unit(fault.seed, fault_stream | (fault.id << salt_bits) | salt, frame);
}

bool is_for(Output wanted, std::string_view output) {
    return wanted == Output::any || to_string(wanted) == output;
}

bool is_in_period(const Fault& fault, TimeNs world_ns, double period_s) {
    if (fault.severity >= 1.0) return true;
    const TimeNs period_ns = std::llround(period_s * 1e9);
    const TimeNs phase_ns = (world_ns - fault.begin_ns) % period_ns;
    return static_cast<double>(phase_ns) < fault.severity * static_cast<double>(period_ns);
}

Result<FaultRef> FaultPlan::set(const FaultSpec& spec, std::uint64_t id, std::uint64_t rig_seed, TimeNs now_ns) {
    if (auto possible = check_sending(spec.kind); !possible) return std::unexpected(possible.error());
    std::erase_if(faults_, [&](const FaultRef& one) { return one->end_ns <= now_ns - kept_ns; });
    Fault fault{id,
                spec.kind,
                spec.begin_ns.value_or(now_ns),
                spec.end_ns.value_or(max_time_ns),
                spec.severity,
                spec.seed.value_or(rig_seed)};
    if (fault.end_ns <= fault.begin_ns) return error(ErrorKind::invalid_argument, "end_s: must be after start_s");
    if (fault.end_ns <= now_ns)
        return error(ErrorKind::invalid_argument,
                     "end_s: is past; world time is " + std::to_string(static_cast<double>(now_ns) * 1e-9) + " s");
    if (faults_.size() >= max_faults) {
        const auto first_over = std::ranges::min_element(faults_, {}, [](const FaultRef& one) { return one->end_ns; });
        if ((*first_over)->end_ns > now_ns)
            return error(ErrorKind::resource_exhausted,
                         "the camera has " + std::to_string(max_faults) + " faults; clear some (fault.clear)");
        faults_.erase(first_over);
    }
    FaultRef made = std::make_shared<const Fault>(std::move(fault));
    faults_.insert(std::ranges::upper_bound(faults_, order_of(made), {}, order_of), made);
    return made;
}

std::vector<FaultRef> FaultPlan::present(TimeNs now_ns) const {
    std::vector<FaultRef> present;
    std::ranges::copy_if(faults_, std::back_inserter(present),
                         [&](const FaultRef& one) { return one->end_ns > now_ns; });
    return present;
}

std::optional<FrameFaults> FaultPlan::at(const FrameKey& frame) const {
    if (faults_.empty()) return std::nullopt;
    FrameFaults found{.frame = frame, .active = {}, .shown_sequence = frame.sequence};
    std::ranges::copy_if(faults_, std::back_inserter(found.active),
                         [&](const FaultRef& one) { return one->is_at(frame.world_ns) && one->severity > 0.0; });
    if (found.active.empty()) return std::nullopt;
    found.is_dropped = is_dropped(found);
    found.harms = std::make_shared<HarmLog>();
    return found;
}

}  // namespace camrig::fault
