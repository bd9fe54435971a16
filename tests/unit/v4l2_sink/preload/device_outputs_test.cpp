#include "tools/camrig/device_outputs.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "tests/unit/v4l2_sink/preload/test_rig.h"

namespace camrig::device {
namespace {

namespace fs = std::filesystem;

/// Answers no command.
struct DeafRig final : engine::CommandPort {
    void post(engine::Command) override {}
};

TEST(DeviceOutputs, ADeviceThatCouldNotBeOpenedIsTriedAgainWithTheNextChangeOfACamera) {
    const TemporaryFolder temporary;
    const std::string socket = temporary / "devices.sock";
    const fs::path folder = socket + ".tree/dev", aside = temporary / "aside";
    DeafRig rig;
    stream::LocalFrameBus bus{{1, std::make_shared<frame::FramePool>()}};
    const auto outputs = cli::DeviceOutputs::create(bus, rig, socket).value();
    const auto camera = [](int id, const std::string& name, std::vector<OutputSpec> devices) {
        return stream::CameraStream{CameraId{static_cast<std::uint32_t>(id)}, name, {64, 48}, {}, std::move(devices)};
    };
    const OutputSpec ten{.kind = "device", .options = {{"number", 10}}};

    fs::rename(folder, aside);
    bus.add_camera(camera(1, "lobby", {ten}));
    fs::rename(aside, folder);
    EXPECT_FALSE(fs::exists(folder / "video10"));
    bus.add_camera(camera(2, "gate", {}));
    EXPECT_TRUE(fs::exists(folder / "video10"));

    fs::rename(folder, aside);
    bus.change_camera(camera(2, "gate", {{.kind = "device", .options = {{"number", 11}}}}));
    fs::rename(aside, folder);
    bus.adjust_camera(camera(1, "lobby", {ten}));
    EXPECT_TRUE(fs::exists(folder / "video10") && fs::exists(folder / "video11"));

    // One that is not configured any more is not tried again.
    fs::rename(folder, aside);
    bus.change_camera(camera(1, "lobby", {ten, {.kind = "device", .options = {{"number", 12}}}}));
    fs::rename(aside, folder);
    bus.change_camera(camera(1, "lobby", {ten}));
    EXPECT_FALSE(fs::exists(folder / "video12"));
}

}  // namespace
}  // namespace camrig::device
