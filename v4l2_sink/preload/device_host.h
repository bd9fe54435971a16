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

/// Answers what programs ask of their devices: the meaning of every request of protocol.h. No threads and no waiting;
/// everything runs on the device server's thread. Messages are checked completely; a peer that breaks the protocol gets
/// an error or loses its connection, never more.
class DeviceHost {
public:
    static constexpr std::size_t max_sessions = 1024;

    /// What comes back from other threads (bus, controls) is posted to `tasks`.
    DeviceHost(stream::FrameBus& bus, std::shared_ptr<ControlPort> controls, const std::shared_ptr<TaskQueue>& tasks);
    ~DeviceHost();

    /// In place of one of the same number, which is unplugged.
    void add_device(int number, std::string camera, codec::ChromaSampling mjpg_sampling);
    /// Its openers see it unplugged.
    void remove_device(int number);
    /// How a camera fails for those who open it and call.
    void set_standing(const std::string& camera, const fault::Standing& standing);
    /// Tells openers who asked for it that somebody else changed these controls of a camera.
    void control_changed(const std::string& camera, std::uint32_t id) { controls_.changed(camera, id); }

    /// One message of one program.
    void receive(const std::shared_ptr<DeviceSession>& session, std::span<const std::byte> message);
    /// The program closed its device, ended or was thrown out.
    void leave(const std::shared_ptr<DeviceSession>& session);
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
    /// Do the two meet in one queue, as two openers of a hardware camera do? Those of one program do.
    bool share_queue(const DeviceSession& a, const DeviceSession& b) const;
    bool owned_by_another(const DeviceSession& session) const;
    void share_priorities(int number);
    /// Tells the library which calls fail.
    void share_errors(DeviceSession& session);
    const std::string& camera_of(const DeviceSession& session) const;
    std::vector<SessionRef> openers_of(const std::string& camera) const;
    /// All who read this ring see their device unplugged.
    void unplug(const std::shared_ptr<FedRing>& ring);
    void end(const SessionRef& session);

    stream::FrameBus& bus_;
    DeviceControls controls_;
    RingPool rings_;
    std::map<int, DeviceState> devices_;
    std::map<std::string, fault::Standing> standing_;  ///< of cameras that fail so
    std::set<SessionRef> sessions_;
    std::vector<SessionRef> ended_;
    ThreadCheck thread_;
};

}  // namespace camrig::device
