#include "core/fault/standing.h"

#include <algorithm>

namespace camrig::fault {

bool Standing::refuses(std::string_view output) const {
    return std::ranges::any_of(names_of(std::type_identity<Output>{}), [&](const Named<Output>& one) {
        return one.name == output && (refused >> static_cast<unsigned>(one.value) & 1u) != 0;
    });
}

bool Standing::fails(DeviceCall call) const {
    return (device_errors >> static_cast<unsigned>(call) & 1u) != 0;
}

Standing standing_of(const FrameFaults& faults) {
    Standing standing;
    const auto refuse = [&](const Fault& one, const auto* how) {
        if (!how || !is_in_period(one, faults.frame.world_ns, how->period_s)) return;
        for (const auto& [output, name] : names_of(std::type_identity<Output>{}))
            if (is_for(how->output, name)) standing.refused |= 1u << static_cast<unsigned>(output);
    };
    for (const FaultRef& one : faults.active) {
        refuse(*one, std::get_if<Refuse>(&one->kind));
        refuse(*one, std::get_if<Restart>(&one->kind));
        if (const auto* const out = std::get_if<Unplug>(&one->kind);
            out && is_in_period(*one, faults.frame.world_ns, out->period_s))
            standing.refused |= 1u << static_cast<unsigned>(Output::device);
        const auto* const failing = std::get_if<DeviceError>(&one->kind);
        if (failing && is_in_period(*one, faults.frame.world_ns, failing->period_s))
            standing.device_errors |= 1u << static_cast<unsigned>(failing->at);
    }
    return standing;
}

}  // namespace camrig::fault
