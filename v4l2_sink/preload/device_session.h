#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/unique_fd.h"
#include "core/stream/frame_bus.h"
#include "v4l2_sink/preload/control_port.h"
#include "v4l2_sink/preload/device_modes.h"
#include "v4l2_sink/preload/device_ring.h"
#include "v4l2_sink/preload/protocol.h"

namespace camrig::device {

/// A ring that is fed by the bus.
struct FedRing {
    std::string camera;
    camrig_format format{};  ///< rate 0/0: the camera's own
    stream::MediaFormat media;
    std::optional<Rate> rate;  ///< lower than the camera's own
    std::shared_ptr<DeviceRing> ring;
    stream::Subscription subscription;
};

/// One /dev/videoN, whoever has it open.
struct DeviceState {
    std::string camera;
    codec::ChromaSampling mjpg_sampling = codec::ChromaSampling::yuv422;
    std::optional<camrig_format> format;  ///< as last set by anybody; new openers start with it
};

/// The result of handling a request: the errno value to reply with, 0 for success; or `answered`, when the handler has
/// sent a reply of its own or will do so later.
using Handled = std::optional<int>;
inline constexpr std::nullopt_t answered = std::nullopt;

/// Copies into a field of fixed size: truncated if it does not fit, always null-terminated.
void copy_text(std::span<char> to, std::string_view text);
int errno_of(const Error& error);

/// One open file description of a device in a program: the rig's end of its two sockets (protocol.h). Device server's
/// thread.
class DeviceSession {
public:
    explicit DeviceSession(UniqueFd control);

    int control_fd() const { return control_.get(); }
    /// Its process id by SO_PEERCRED; 0 if it runs in another pid namespace.
    pid_t peer_process() const;
    /// Sends a message without blocking. A peer whose socket is full is given up: `dead` is set.
    void send(std::span<const std::byte> message, std::span<const int> fds = {});
    void reply(std::uint32_t serial, camrig_reply reply, std::span<const int> fds = {});
    void fail(std::uint32_t serial, int error_number, std::uint32_t detail = 0);
    /// Sends a control event. While the peer does not read, only the newest event of each control is kept, as in the
    /// kernel.
    void tell(const camrig_control_event& event);
    /// Sends the events that wait, if the peer takes them.
    void send_waiting();

    std::uint64_t process = 0;  ///< who opened it, as it says
    bool dead = false;
    std::optional<int> number;  ///< after HELLO
    camrig_description description{};
    camrig_format format{};  ///< what this opener reads, if it chose
    bool format_chosen = false;
    bool owns_buffers = false;
    std::uint32_t priority = 0;
    std::map<std::uint32_t, bool> subscriptions;  ///< control id -> feedback of own changes

    UniqueFd event_socket;
    SharedMemory page;
    std::shared_ptr<stream::ReaderStats> stats;
    std::shared_ptr<RingReader> reader;
    std::shared_ptr<FedRing> ring;  ///< while streaming
    bool awaits_reply = false;      ///< a question or a change of a control is under way

    camrig_reader_page& shared() const { return *reinterpret_cast<camrig_reader_page*>(page.data()); }

private:
    UniqueFd control_;
    std::map<std::uint32_t, camrig_control_event> waiting_;  ///< by control
};

}  // namespace camrig::device
