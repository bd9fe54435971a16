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

/// What handling a request gives: the errno value that its reply tells, 0 for success; or that the reply, with more in
/// it, was sent or will be.
using Handled = std::optional<int>;
inline constexpr std::nullopt_t answered = std::nullopt;

/// With a zero at the end, cut to fit.
void copy_text(std::span<char> to, std::string_view text);
int errno_of(const Error& error);

/// One open() of a device by a program: the rig's end of its two sockets. Device server's thread.
class DeviceSession {
public:
    explicit DeviceSession(UniqueFd control);

    int control_fd() const { return control_.get(); }
    /// Its number, as the kernel knows it here; 0: of another process namespace.
    pid_t peer_process() const;
    /// Sends a message, never waiting; a peer that does not take it is given up (`dead`).
    void send(std::span<const std::byte> message, std::span<const int> fds = {});
    void reply(std::uint32_t serial, camrig_reply reply, std::span<const int> fds = {});
    void fail(std::uint32_t serial, int error_number, std::uint32_t detail = 0);
    /// A control has a new value. While the peer does not read, of each control the newest waits, as in the kernel.
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
