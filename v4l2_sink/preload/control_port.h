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
    std::string name;  ///< the kernel's name of the control; v4l2-ctl and usb_cam find controls by it
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

/// The camera controls that user-space devices offer as V4L2 controls. The rig implements it. Calls come from the
/// device server's thread and must not block: list() and get() answer from a cache.
class ControlPort {
public:
    virtual ~ControlPort() = default;
    virtual std::vector<DeviceControl> list(std::string_view camera) = 0;
    /// The value that was set last.
    virtual Result<std::int32_t> get(std::string_view camera, std::uint32_t id) = 0;
    /// The present value, which differs from the one that was set while a control moves there (pan, tilt, zoom of a PTZ
    /// head). `done` is called once, from any thread.
    virtual void ask(std::string_view camera, std::uint32_t id, std::function<void(Result<std::int32_t>)> done) {
        done(get(camera, id));
    }
    /// Sets all of the values, or none if one is refused. They are within the ranges of list(). `done` is called once,
    /// from any thread.
    virtual void set(std::string_view camera, std::span<const DeviceControlValue> values,
                     std::function<void(Result<void>)> done) = 0;
};

}  // namespace camrig::device
