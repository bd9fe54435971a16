#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/engine/command.h"
#include "tools/camrig/control_table.h"
#include "v4l2_sink/preload/control_port.h"

namespace camrig::cli {

/// The V4L2 controls of the rig's cameras. A change is a camera.set like any other, in the engine's queue; the values
/// are those of the latest state that was told. Pan and tilt are the camera's in the world (0: along +x, level), pan to
/// the right and tilt up, in arc seconds; zoom is in percent of the camera's optics. Of a camera on a head they are the
/// head's, and speeds of pan and tilt come with it: who asks is told where it believes to be at that time, who hears of
/// changes where they bring it. Exposure, gain and white balance of a camera with a sensor are the sensor's, of another
/// those of its finished picture. See docs/devices.md for the others.
///
/// list, get, ask, set: the device server's thread. refresh, forget: the engine's thread (bus observers). Answers come
/// on the engine's thread.
class CameraControls final : public device::ControlPort, public std::enable_shared_from_this<CameraControls> {
public:
    /// `changed` hears of values that others changed; it must not block.
    using Changed = std::function<void(const std::string& camera, const std::vector<std::uint32_t>& ids)>;

    /// The port must outlive all answers.
    explicit CameraControls(engine::CommandPort& commands) : commands_(commands) {}

    void on_change(Changed changed);

    std::vector<device::DeviceControl> list(std::string_view camera) override;
    Result<std::int32_t> get(std::string_view camera, std::uint32_t id) override;
    void ask(std::string_view camera, std::uint32_t id, std::function<void(Result<std::int32_t>)> done) override;
    void set(std::string_view camera, std::span<const device::DeviceControlValue> values,
             std::function<void(Result<void>)> done) override;

    /// The camera is new or was changed: asks for its state.
    void refresh(const std::string& camera);
    void forget(const std::string& camera);

private:
    /// Lets the camera fail as these values say. They came in one call with no others: vivid's are of a class of their
    /// own.
    void set_errors(const std::string& camera, std::span<const device::DeviceControlValue> values,
                    std::function<void(Result<void>)> done);
    void told(const engine::CameraReply& report);
    std::optional<KnownCamera> known(std::string_view camera) const;

    engine::CommandPort& commands_;
    mutable std::mutex mutex_;  ///< guards what follows
    Changed changed_;
    std::map<std::string, KnownCamera, std::less<>> known_;
    /// Controls that programs are setting: who sets one hears nothing of it from here, others from the device server.
    std::map<std::string, std::multiset<std::uint32_t>> being_set_;
};

}  // namespace camrig::cli
