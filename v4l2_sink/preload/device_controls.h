#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "v4l2_sink/preload/control_port.h"
#include "v4l2_sink/preload/device_session.h"
#include "v4l2_sink/task_queue.h"

namespace camrig::device {

/// The controls of all devices: requested control changes go to the rig's ControlPort, changes to all who subscribed to
/// them. Device server's thread.
class DeviceControls {
public:
    using SessionRef = std::shared_ptr<DeviceSession>;
    /// Who has a device of this camera open now.
    using Openers = std::function<std::vector<SessionRef>(const std::string& camera)>;

    DeviceControls(std::shared_ptr<ControlPort> port, std::shared_ptr<TaskQueue> tasks, Openers openers)
        : port_(std::move(port)), tasks_(std::move(tasks)), openers_(std::move(openers)) {}

    /// Fills in the list of controls.
    void describe(const std::string& camera, camrig_description& description);
    /// Answered once the rig has said what the value is now.
    Handled get(const SessionRef& session, const std::string& camera, const camrig_request& request);
    /// Answered once the rig has done it.
    Handled set(const SessionRef& session, const std::string& camera, const camrig_request& request);
    Handled menu(DeviceSession& session, const std::string& camera, const camrig_request& request);
    static Handled subscribe(DeviceSession& session, const camrig_request& request);
    /// Somebody other than a program changed these.
    void changed(const std::string& camera, std::uint32_t id);

private:
    void tell(const DeviceSession* by, const std::string& camera, std::uint32_t id, std::int32_t value);

    const std::shared_ptr<ControlPort> port_;
    const std::shared_ptr<TaskQueue> tasks_;
    const Openers openers_;
};

}  // namespace camrig::device
