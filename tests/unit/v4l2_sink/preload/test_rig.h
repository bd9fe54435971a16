#pragma once

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <system_error>
#include <vector>

#include <linux/videodev2.h>

#include "core/base/clock.h"
#include "core/frame/code_strip.h"
#include "core/stream/local_frame_bus.h"
#include "tests/temporary_folder.h"
#include "v4l2_sink/preload/device_server.h"

namespace camrig::device {

/// Controls that are kept and nothing else.
class StoredControls final : public ControlPort {
public:
    StoredControls() {
        for (const DeviceControl& control : all()) values_[control.id] = control.default_value;
    }
    std::vector<DeviceControl> list(std::string_view) override { return all(); }
    Result<std::int32_t> get(std::string_view, std::uint32_t id) override {
        std::lock_guard lock(mutex_);
        const auto found = values_.find(id);
        if (found == values_.end()) return error(ErrorKind::not_found, "no such control");
        return found->second;
    }
    void set(std::string_view, std::span<const DeviceControlValue> values,
             std::function<void(Result<void>)> done) override {
        {
            std::lock_guard lock(mutex_);
            for (const auto& [id, value] : values) values_[id] = value;
        }
        done({});
    }
    static std::vector<DeviceControl> all() {
        using enum DeviceControl::Kind;
        return {
            {V4L2_CID_BRIGHTNESS, integer, "Brightness", -64, 64, 1, 0, 0, {}},
            {V4L2_CID_CONTRAST, integer, "Contrast", 0, 64, 1, 32, 0, {}},
            {V4L2_CID_SATURATION, integer, "Saturation", 0, 128, 1, 64, 0, {}},
            {V4L2_CID_AUTO_WHITE_BALANCE, boolean, "White Balance, Automatic", 0, 1, 1, 1, 0, {}},
            {V4L2_CID_GAIN, integer, "Gain", 0, 100, 1, 0, 0, {}},
            {V4L2_CID_WHITE_BALANCE_TEMPERATURE, integer, "White Balance Temperature", 2800, 6500, 10, 4600, 0, {}},
            {V4L2_CID_EXPOSURE_AUTO,
             menu,
             "Auto Exposure",
             1,
             3,
             1,
             3,
             0,
             {"Manual Mode", "", "Aperture Priority Mode"}},
            {V4L2_CID_EXPOSURE_ABSOLUTE, integer, "Exposure Time, Absolute", 1, 5000, 1, 157, 0, {}},
            {V4L2_CID_PAN_ABSOLUTE, integer, "Pan, Absolute", -648000, 648000, 3600, 0, 0, {}},
            {V4L2_CID_TILT_ABSOLUTE, integer, "Tilt, Absolute", -324000, 324000, 3600, 0, 0, {}},
            {V4L2_CID_ZOOM_ABSOLUTE, integer, "Zoom, Absolute", 100, 1000, 1, 100, 0, {}},
        };
    }

private:
    std::mutex mutex_;
    std::map<std::uint32_t, std::int32_t> values_;
};

/// Makes pictures whose every pixel tells their number: a grey level that follows from the sequence, and the code
/// strip.
class PictureMaker {
public:
    explicit PictureMaker(stream::CameraStream camera)
        : camera_(std::move(camera)), name_(std::make_shared<const std::string>(camera_.name)) {}

    const stream::CameraStream& camera() const { return camera_; }
    /// Limited to 40..215, so that conversions do not clip.
    static int grey_of(std::int64_t sequence) { return 40 + static_cast<int>(sequence * 37 % 176); }

    frame::FrameRef make(std::int64_t sequence, TimeNs world_ns, TimeNs monotonic_ns) {
        frame::FrameInfo info;
        info.camera_id = camera_.id;
        info.camera = name_;
        info.sequence = sequence;
        info.world_ns = world_ns;
        info.monotonic_ns = monotonic_ns;
        info.size = camera_.size;
        info.faults = faults;
        auto frame = pool_.acquire(info);
        auto bytes = frame->mutable_bytes();
        std::ranges::fill(bytes, static_cast<std::byte>(grey_of(sequence)));
        frame::draw_code_strip(bytes, camera_.size,
                               {static_cast<std::uint8_t>(camera_.id), static_cast<std::uint32_t>(sequence), world_ns});
        return frame;
    }

    std::shared_ptr<const fault::FrameFaults> faults;  ///< of pictures that are made from now on

private:
    const stream::CameraStream camera_;
    const std::shared_ptr<const std::string> name_;
    frame::FramePool pool_;
};

/// A frame bus with one camera ("lobby", number 10) and a device server, driven by the test.
class TestRig {
public:
    explicit TestRig(ImageSize size = {320, 240}, Rate rate = *Rate::create(30, 1))
        : maker({CameraId{1}, "lobby", size, rate}) {
        bus.add_camera(maker.camera());
        auto created = DeviceServer::create(bus, folder / "devices.sock", controls);
        CHECK(created.has_value());
        server = std::move(*created);
        CHECK(server->add_device(10, "lobby", codec::ChromaSampling::yuv422).has_value());
    }
    /// Shows the next picture of the camera; in lockstep under a latch.
    void show(const std::shared_ptr<stream::DeliveryLatch>& latch = nullptr) {
        frame::FrameSet set;
        const std::int64_t n = next++;
        set.world_ns = maker.camera().rate.time_of_frame(n);
        set.monotonic_ns = monotonic_now_ns();
        if (!bus.wanted(maker.camera().id, set.world_ns).empty())
            set.frames.push_back(maker.make(n, set.world_ns, set.monotonic_ns));
        bus.publish(set, latch);
    }

    /// The programs that stream.
    std::vector<stream::ReaderReport> programs() const {
        stream::RigReport report;
        report.cameras.emplace_back().name = "lobby";
        bus.fill_report(report);
        std::vector<stream::ReaderReport> programs;
        for (const stream::OutputReport& output : report.cameras[0].outputs)
            std::ranges::copy_if(output.readers, std::back_inserter(programs), [](const stream::ReaderReport& reader) {
                return reader.peer.starts_with("/dev/video");
            });
        return programs;
    }

    TemporaryFolder folder;
    stream::LocalFrameBus bus{{2, std::make_shared<frame::FramePool>()}};
    std::shared_ptr<StoredControls> controls = std::make_shared<StoredControls>();
    std::unique_ptr<DeviceServer> server;
    PictureMaker maker;
    std::int64_t next = 0;
};

}  // namespace camrig::device
