#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/stream/frame_bus.h"
#include "v4l2_sink/preload/control_port.h"
#include "v4l2_sink/preload/device_session.h"
#include "v4l2_sink/task_queue.h"

namespace camrig {

/// Answers what programs ask of their devices: the meaning of every request of protocol.h. No threads and no waiting;
/// everything runs on the device server's thread. Messages are checked completely; a peer that breaks the protocol gets
/// an error or loses its connection, never more.
class DeviceHost {
public:
    static constexpr std::size_t max_sessions = 1024;

    /// What comes back from other threads (bus, controls) is posted to `tasks`.
    DeviceHost(FrameBus& bus, std::shared_ptr<ControlPort> controls, std::shared_ptr<TaskQueue> tasks)
        : bus_(bus), controls_(std::move(controls)), tasks_(std::move(tasks)) {}
    ~DeviceHost();

    void add_device(int number, std::string camera, DevicePolicy policy);
    /// Its openers see it unplugged.
    void remove_device(int number);
    /// Tells openers who asked that the values of a camera's controls may have changed.
    void controls_changed(const std::string& camera);

    /// One message of one program.
    void receive(const std::shared_ptr<DeviceSession>& session, std::span<const std::byte> message);
    /// The program closed its device, ended or was thrown out.
    void leave(const std::shared_ptr<DeviceSession>& session);
    /// Keeps silent cameras alive (see DeviceRing::repeat_if_idle).
    void tick(TimeNs monotonic_ns);

    /// Sessions whose connection the caller shall close.
    std::vector<std::shared_ptr<DeviceSession>> take_ended() { return std::exchange(ended_, {}); }
    std::vector<std::shared_ptr<ReaderStats>> reader_stats() const;

private:
    using SessionRef = std::shared_ptr<DeviceSession>;
    int hello(const SessionRef& session, const camrig_request& request);
    int get_format(const SessionRef& session, const camrig_request& request);
    int set_format(const SessionRef& session, const camrig_request& request);
    int acquire(const SessionRef& session);
    int stream_on(const SessionRef& session, const camrig_request& request);
    void stream_off(const SessionRef& session);
    int get_control(const SessionRef& session, const camrig_request& request);
    int set_controls(const SessionRef& session, const camrig_request& request);
    int menu(const SessionRef& session, const camrig_request& request);
    int subscribe(const SessionRef& session, const camrig_request& request);
    int set_priority(const SessionRef& session, std::uint32_t priority);

    int describe(DeviceSession& session, const DeviceState& device, int number);
    camrig_format format_of(const DeviceSession& session) const;
    /// Do the two meet in one queue, as two openers of a hardware camera do?
    bool share_queue(const DeviceSession& a, const DeviceSession& b) const;
    bool owned_by_another(const DeviceSession& session) const;
    void share_priorities(int number);
    void tell_change(const DeviceSession* by, const std::string& camera, std::uint32_t id, std::int32_t value);
    /// The ring of this format, existing or new; null when the bus has no such camera.
    Result<std::shared_ptr<FedRing>> ring_for(const std::string& camera, const camrig_format& format);
    Result<void> feed(const std::shared_ptr<FedRing>& ring);
    void ring_ended(const std::shared_ptr<FedRing>& ring);
    void end(const SessionRef& session);

    FrameBus& bus_;
    const std::shared_ptr<ControlPort> controls_;
    const std::shared_ptr<TaskQueue> tasks_;
    std::map<int, DeviceState> devices_;
    std::set<SessionRef> sessions_;
    std::vector<std::weak_ptr<FedRing>> rings_;
    std::vector<SessionRef> ended_;
};

}  // namespace camrig
