#pragma once

#include "core/fault/fault_plan.h"

namespace camrig::fault {

inline FaultRef fault_of(FaultKind kind, double severity = 1.0, std::uint64_t seed = 7) {
    return std::make_shared<const Fault>(Fault{.id = 1, .kind = std::move(kind), .severity = severity, .seed = seed});
}

/// One fault, at that frame of a camera of 25 frames a second.
inline FrameFaults at_frame(const FaultRef& fault, std::int64_t sequence) {
    return {.frame = {sequence, sequence * 40 * ns_per_ms}, .active = {fault}, .shown_sequence = sequence};
}

}  // namespace camrig::fault
