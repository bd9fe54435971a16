#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace camrig::device {

/// One V4L2 control of a camera, in V4L2's units (pan and tilt: arc seconds; exposure: 100 us; white balance: kelvin).
struct DeviceControl {
    enum class Kind : std::uint8_t { integer, boolean, menu, button };
    std::uint32_t id = 0;  ///< V4L2_CID_*
    Kind kind = Kind::integer;
    std::string name;  ///< as the kernel names it; v4l2-ctl and usb_cam go by it
    std::int32_t minimum = 0;
    std::int32_t maximum = 0;
    std::int32_t step = 1;
    std::int32_t default_value = 0;
    std::uint32_t flags = 0;        ///< V4L2_CTRL_FLAG_*
    std::vector<std::string> menu;  ///< menu: the entry of value minimum, minimum + 1, ...; empty text: no such entry
};

struct DeviceControlValue {
    std::uint32_t id = 0;
    std::int32_t value = 0;
};

/// What the controls of user-space devices act on; passed in by the composition root. list() and get() answer from
/// what is known; nothing blocks; calls come from the device server's thread.
class ControlPort {
public:
    virtual ~ControlPort() = default;
    virtual std::vector<DeviceControl> list(std::string_view camera) = 0;
    /// The value that was set last.
    virtual Result<std::int32_t> get(std::string_view camera, std::uint32_t id) = 0;
    /// The value now, which another is of what is on its way to what was set. `done` is called once, from any thread.
    virtual void ask(std::string_view camera, std::uint32_t id, std::function<void(Result<std::int32_t>)> done) {
        done(get(camera, id));
    }
    /// All of the values or none; they are within the limits of list(). `done` is called once, from any thread.
    virtual void set(std::string_view camera, std::span<const DeviceControlValue> values,
                     std::function<void(Result<void>)> done) = 0;
};

}  // namespace camrig::device
