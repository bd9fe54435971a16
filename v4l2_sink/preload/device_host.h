#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/base/thread_check.h"
#include "core/stream/frame_bus.h"
#include "v4l2_sink/preload/device_controls.h"
#include "v4l2_sink/preload/device_session.h"
#include "v4l2_sink/preload/ring_pool.h"
#include "v4l2_sink/task_queue.h"

namespace camrig::device {

/// Handles the requests that programs send for their open devices (protocol.h). Never blocks; everything runs on the
/// device server's thread. Messages are validated completely: a peer that violates the protocol gets an error or is
/// disconnected.
class DeviceHost {
public:
    static constexpr std::size_t max_sessions = 1024;

    /// Callbacks of other threads (bus, controls) post to `tasks`, which the device server's thread runs.
    DeviceHost(stream::FrameBus& bus, std::shared_ptr<ControlPort> controls, const std::shared_ptr<TaskQueue>& tasks,
               bool is_lockstep = false);
    ~DeviceHost();

    /// Replaces a device of the same number: programs that have that open see it unplugged.
    void add_device(int number, std::string camera, codec::ChromaSampling mjpg_sampling);
    /// Programs that have it open see it unplugged.
    void remove_device(int number);
    /// Sets which V4L2 calls on this camera's devices fail from now on (fault injection).
    void set_standing(const std::string& camera, const fault::Standing& standing);
    /// Sends an event of this control to its subscribers: its value was changed, but not through a device.
    void control_changed(const std::string& camera, std::uint32_t id) { controls_.changed(camera, id); }

    /// Handles a message that came from a program.
    void receive(const std::shared_ptr<DeviceSession>& session, std::span<const std::byte> message);
    /// The connection has ended: the program closed its device, exited or was disconnected.
    void leave(const std::shared_ptr<DeviceSession>& session);
    /// Repeats last frames that are due (RingPool::tick), and ends the sessions of peers that take no messages. To be
    /// called a few times a second.
    void tick(TimeNs monotonic_ns);

    /// Sessions whose connection the caller shall close.
    std::vector<std::shared_ptr<DeviceSession>> take_ended() { return std::exchange(ended_, {}); }

private:
    using SessionRef = std::shared_ptr<DeviceSession>;
    Handled hello(const SessionRef& session, const camrig_request& request);
    Handled get_format(const SessionRef& session, const camrig_request& request);
    Handled set_format(const SessionRef& session, const camrig_request& request);
    Handled acquire(const SessionRef& session);
    Handled stream_on(const SessionRef& session, const camrig_request& request);
    void stream_off(const SessionRef& session);
    Handled set_priority(const SessionRef& session, std::uint32_t priority);

    int describe(DeviceSession& session, const DeviceState& device, int number);
    camrig_format format_of(const DeviceSession& session) const;
    /// Whether two sessions share one buffer queue. In the kernel all openers of a device do; here those of one
    /// process.
    bool share_queue(const DeviceSession& a, const DeviceSession& b) const;
    bool owned_by_another(const DeviceSession& session) const;
    void share_priorities(int number);
    /// Writes to the shared reader page which calls fail.
    void share_errors(DeviceSession& session);
    const std::string& camera_of(const DeviceSession& session) const;
    std::vector<SessionRef> openers_of(const std::string& camera) const;
    /// Programs that read this ring see their device unplugged.
    void unplug(const std::shared_ptr<FedRing>& ring);
    void end(const SessionRef& session);

    stream::FrameBus& bus_;
    DeviceControls controls_;
    RingPool rings_;
    std::map<int, DeviceState> devices_;
    std::map<std::string, fault::Standing> standing_;  ///< by camera: which calls fail
    std::set<SessionRef> sessions_;
    std::vector<SessionRef> ended_;
    ThreadCheck thread_;
};

}  // namespace camrig::device
