#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/base/result.h"
#include "core/base/unique_fd.h"
#include "core/stream/frame_bus.h"
#include "v4l2_sink/preload/control_port.h"
#include "v4l2_sink/preload/device_session.h"
#include "v4l2_sink/preload/device_tree.h"
#include "v4l2_sink/task_queue.h"

namespace camrig::device {

/// Serves the rig's user-space /dev/videoN: a Unix socket (mode 0600) to which programs under `camrig exec` connect
/// when they open a device. One thread of its own; calls from any thread.
class DeviceServer {
public:
    static constexpr int max_connections = 1100;

    /// already_exists: another rig serves this socket. The bus must outlive the server. `is_lockstep`: readers get the
    /// pictures that were asked for and no other; else a camera that is silent repeats its last one.
    static Result<std::unique_ptr<DeviceServer>> create(stream::FrameBus& bus, const std::string& socket_path,
                                                        std::shared_ptr<ControlPort> controls,
                                                        bool is_lockstep = false);
    /// Programs see their devices unplugged.
    ~DeviceServer();

    /// Adds /dev/video<number>, number 0..255, which shows the camera of this name. The camera need not exist yet.
    Result<void> add_device(int number, const std::string& camera, codec::ChromaSampling mjpg_sampling);
    void remove_device(int number);
    /// Sets which V4L2 calls on this camera's devices fail from now on (fault injection).
    void set_standing(const std::string& camera, const fault::Standing& standing);
    /// Somebody other than a device's program changed these controls: sends events to those who subscribed.
    void controls_changed(const std::string& camera, const std::vector<std::uint32_t>& ids);

    const std::string& socket_path() const { return socket_path_; }

private:
    class Loop;
    DeviceServer(std::string socket_path, DeviceTree tree, std::unique_ptr<Loop> loop,
                 std::shared_ptr<TaskQueue> tasks);

    const std::string socket_path_;
    const std::shared_ptr<TaskQueue> tasks_;
    mutable std::mutex mutex_;  ///< guards tree_ and numbers_
    DeviceTree tree_;
    std::map<int, std::string> numbers_;  ///< camera by number of its device
    std::unique_ptr<Loop> loop_;
    std::thread thread_;
};

}  // namespace camrig::device
