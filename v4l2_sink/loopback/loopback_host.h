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

/// What one device shall show.
struct LoopbackSettings {
    int number = 0;
    std::string camera;
    LoopbackFormat format;
};

/// Brings the loopback devices to their settings, and keeps them there: makes and removes them, opens them,
/// subscribes to the bus while somebody reads, keeps silent ones alive, tries again what did not work (each failure is
/// logged once). No thread and no waiting of its own; everything runs on the loopback server's thread.
class LoopbackHost {
public:
    struct Options {
        /// Subscribe even while nobody reads: for lockstep, where a reader that was just opened may miss no picture.
        bool always_subscribed = false;
    };

    /// What comes back from other threads (bus, fetcher) is posted to `tasks`.
    LoopbackHost(stream::FrameBus& bus, stream::FrameFetcher& fetcher, LoopbackKernel& kernel,
                 std::shared_ptr<TaskQueue> tasks, Options options);
    /// Removes the rig's own devices; one that is being read stays, for the next rig.
    ~LoopbackHost();

    /// A new device, or a change of one: the number decides.
    void set(LoopbackSettings settings, TimeNs monotonic_ns);
    void unset(int number, TimeNs monotonic_ns);
    /// Whatever is due. A few times a second, and when one of watch_fds() is ready.
    void tick(TimeNs monotonic_ns);
    /// To be polled for POLLPRI.
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
        TimeNs refresh_ns = 0;  ///< when to fetch a picture again that nobody reads
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
