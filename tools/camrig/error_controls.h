#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/fault/fault_plan.h"
#include "v4l2_sink/preload/control_port.h"

namespace camrig::cli {

/// Controls by which programs let their device fail, with the numbers and names that the kernel's test driver vivid has
/// for them (drivers/media/test-drivers/vivid/vivid-ctrls.c): what is tried with one is tried with the other. Each sets
/// a fault of the camera.
std::vector<device::DeviceControl> error_controls();
bool is_error_control(std::uint32_t id);

/// So long a button's fault lasts in world time: vivid's act once, on what a program does next.
inline constexpr TimeNs pressed_ns = ns_per_s;

/// What setting it comes to. `kind`: of faults that are cleared before; empty: none.
struct ErrorSetting {
    std::string_view clears;
    std::optional<fault::FaultSpec> fault;  ///< nullopt: none is set; without begin and end
    bool is_button = true;                  ///< it lasts pressed_ns; otherwise until it is set anew
};
ErrorSetting error_setting(std::uint32_t id, std::int32_t value);

/// The value that a control has while these faults act: a button's is 0.
std::int32_t error_value(std::uint32_t id, std::span<const fault::FaultRef> faults);

}  // namespace camrig::cli
