#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/thread_check.h"
#include "core/stream/frame_bus.h"
#include "v4l2_sink/loopback/device.h"
#include "v4l2_sink/loopback/kernel.h"
#include "v4l2_sink/loopback/loopback_sink.h"
#include "v4l2_sink/loopback/module.h"
#include "v4l2_sink/task_queue.h"

namespace camrig::device {

/// The configuration of one device: its camera and format.
struct LoopbackSettings {
    int number = 0;
    std::string camera;
    LoopbackFormat format;
};

/// Manages the loopback devices of a rig: creates, opens and removes them according to their settings, subscribes to
/// the frame bus while a program reads, repeats the last frame of a camera that sends none, and retries what failed
/// (each failure is logged once). Never blocks; everything runs on the loopback server's thread.
class LoopbackHost {
public:
    struct Options {
        /// Pictures come when a client steps the world. The camera is subscribed to even while no program reads, as one
        /// that has just opened the device must not miss a frame; and who reads gets no picture that nobody asked for.
        bool is_lockstep = false;
    };

    /// Callbacks of other threads (bus, fetcher) post to `tasks`, which the loopback server's thread runs.
    LoopbackHost(stream::FrameBus& bus, stream::FrameFetcher& fetcher, LoopbackKernel& kernel,
                 std::shared_ptr<TaskQueue> tasks, Options options);
    /// Removes the devices that this rig created, except those that a program still has open; the next rig uses them.
    ~LoopbackHost();

    /// Adds a device, or changes the settings of the one that has this number.
    void set(LoopbackSettings settings, TimeNs monotonic_ns);
    /// No camera has this device any more: closes it, and removes it if this rig created it.
    void unset(int number, TimeNs monotonic_ns);
    /// Does what is due: retries, repeated frames, readers that came or went. To be called a few times a second, and
    /// when one of watch_fds() is ready.
    void tick(TimeNs monotonic_ns);
    /// Descriptors to poll for POLLPRI (LoopbackDevice::readers_fd).
    std::vector<int> watch_fds() const;
    bool is_idle() const { return devices_.empty(); }

private:
    /// Not open; will be, at Device::retry_ns.
    struct Closed {};
    /// Open, and shows its camera's pictures.
    struct Open {
        std::shared_ptr<LoopbackSink> sink;
        LoopbackFormat shown;  ///< differs from the configured one while a program holds the device
        std::optional<stream::Subscription> subscription = {};
        bool is_read = false;
        bool is_fetching = false;
        TimeNs refresh_ns = 0;  ///< while nobody reads: when to fetch a recent picture again (LoopbackSink::refresh)
    };
    /// Closed, and no camera wants it: removed at Device::retry_ns if it is the rig's.
    struct Leaving {};

    struct Device {
        std::variant<Closed, Open, Leaving> state;
        LoopbackSettings settings;  ///< the last one, when Leaving
        bool is_own = false;        ///< this rig made it, and will remove it
        TimeNs made_ns = 0;
        TimeNs retry_ns = 0;   ///< when to try again what failed
        TimeNs reopen_ns = 0;  ///< while another format is shown: when to look whether a program still holds it
        std::string last_error;
    };

    void open(Device& device, TimeNs monotonic_ns);
    Result<std::unique_ptr<LoopbackDevice>> try_open(Device& device, TimeNs monotonic_ns);
    void close(Device& device);
    /// An open device's turn.
    void update(Device& device, TimeNs monotonic_ns);
    void subscribe(Device& device, Open& open, TimeNs monotonic_ns);
    void fetch(const Device& device, Open& open);
    /// Opens the device anew if it shows another format than the configured one and nobody holds it. Null: it could
    /// not.
    Open* apply_format(Device& device, bool may_reopen, TimeNs monotonic_ns);
    /// The device of this number if it is open with this sink, for what comes back from other threads; else null.
    Device* find(int number, const std::weak_ptr<LoopbackSink>& sink);
    /// True if nothing is left to do.
    bool remove(Device& device, TimeNs monotonic_ns);
    void report(Device& device, const Error& why, TimeNs monotonic_ns);

    stream::FrameBus& bus_;
    stream::FrameFetcher& fetcher_;
    LoopbackKernel& kernel_;
    const LoopbackModule module_;
    const std::shared_ptr<TaskQueue> tasks_;
    const Options options_;
    std::map<int, Device> devices_;  ///< by number
    ThreadCheck thread_;
};

}  // namespace camrig::device
