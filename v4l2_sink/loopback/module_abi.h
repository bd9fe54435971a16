#pragma once

#include <cstdint>

#include <linux/videodev2.h>

namespace camrig::device {

// What v4l2loopback adds to V4L2. The kernel has no header for it, so the numbers are written down here; the struct is
// the same from 0.13.0 to 0.15.4, and 0.15 still takes the older request numbers, so these serve every version.

inline constexpr const char* loopback_control_node = "/dev/v4l2loopback";  ///< since 0.13
inline constexpr const char* loopback_driver_name = "v4l2 loopback";       ///< VIDIOC_QUERYCAP's driver

/// Argument of add.
struct LoopbackConfig {
    std::int32_t number = -1;  ///< N of /dev/videoN
    std::int32_t unused = 0;
    char card_label[32] = {};  ///< ends with 0
    std::uint32_t min_width = 0;
    std::uint32_t max_width = 0;
    std::uint32_t min_height = 0;
    std::uint32_t max_height = 0;
    std::int32_t max_buffers = 0;
    std::int32_t max_openers = 0;
    std::int32_t debug = 0;
    std::int32_t announce_all_caps = 0;  ///< the opposite of the module's parameter exclusive_caps
};
static_assert(sizeof(LoopbackConfig) == 72);

inline constexpr unsigned long loopback_add = 0x4C80;     ///< LoopbackConfig*; gives the device's number
inline constexpr unsigned long loopback_remove = 0x4C81;  ///< the number itself; EBUSY while somebody has it open
inline constexpr unsigned long loopback_get_version = 0x80047E00;  ///< std::uint32_t*: 0xMMmmpp; since 0.15

inline constexpr std::uint32_t loopback_keep_format = (V4L2_CID_USER_BASE | 0xf000) + 0;  ///< control, 0 or 1

/// Event of a device: how many programs read it (from 0.14 on: 0 or 1), in the event's first 32 bits. Since 0.13.
inline constexpr std::uint32_t loopback_client_usage = V4L2_EVENT_PRIVATE_START + 0x08E00000 + 1;

}  // namespace camrig::device
