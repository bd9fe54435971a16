#pragma once

#include <cstdint>
#include <string_view>

#include "core/fault/fault_plan.h"

/// Layer transport: what is a matter of those who come, not of frames.
namespace camrig::fault {

/// What fails of a camera whether or not anybody reads it.
struct Standing {
    std::uint32_t refused = 0;        ///< a bit for each Output: who comes is not let in
    std::uint32_t device_errors = 0;  ///< a bit for each DeviceCall: it fails
    bool refuses(std::string_view output) const;
    bool fails(DeviceCall call) const;
    friend bool operator==(const Standing&, const Standing&) = default;
};
Standing standing_of(const FrameFaults& faults);

}  // namespace camrig::fault
