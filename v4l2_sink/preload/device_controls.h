#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "v4l2_sink/preload/control_port.h"
#include "v4l2_sink/preload/device_session.h"
#include "v4l2_sink/task_queue.h"

namespace camrig::device {

/// Handles the control requests of all devices (VIDIOC_QUERYCTRL, G_CTRL, S_CTRL, SUBSCRIBE_EVENT): passes them to the
/// rig's ControlPort, and sends control events to the programs that subscribed. Device server's thread.
class DeviceControls {
public:
    using SessionRef = std::shared_ptr<DeviceSession>;
    /// The sessions that have a device of this camera open.
    using Openers = std::function<std::vector<SessionRef>(const std::string& camera)>;

    DeviceControls(std::shared_ptr<ControlPort> port, std::shared_ptr<TaskQueue> tasks, Openers openers)
        : port_(std::move(port)), tasks_(std::move(tasks)), openers_(std::move(openers)) {}

    /// Fills in the list of controls.
    void describe(const std::string& camera, camrig_description& description);
    /// Replies when ControlPort::ask() has called back.
    Handled get(const SessionRef& session, const std::string& camera, const camrig_request& request);
    /// Replies when ControlPort::set() has called back.
    Handled set(const SessionRef& session, const std::string& camera, const camrig_request& request);
    Handled menu(DeviceSession& session, const std::string& camera, const camrig_request& request);
    static Handled subscribe(DeviceSession& session, const camrig_request& request);
    /// Sends an event of this control to its subscribers: its value was changed, but not through a device.
    void changed(const std::string& camera, std::uint32_t id);

private:
    void tell(const DeviceSession* by, const std::string& camera, std::uint32_t id, std::int32_t value);

    const std::shared_ptr<ControlPort> port_;
    const std::shared_ptr<TaskQueue> tasks_;
    const Openers openers_;
};

}  // namespace camrig::device
