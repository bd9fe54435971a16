#include "v4l2_sink/loopback/module.h"

#include <gmock/gmock.h>

#include "tests/unit/v4l2_sink/loopback/fake_module.h"
#include "v4l2_sink/loopback/loopback_server.h"

namespace camrig::device {
namespace {

using testing::HasSubstr;

TEST(LoopbackModule, TellsWhatEachGenerationCan) {
    struct Case {
        int minor;
        bool adds, tells, streams;
    };
    for (const Case& c : {Case{12, false, false, false}, Case{13, true, true, false}, Case{14, true, true, true},
                          Case{15, true, true, true}}) {
        FakeModule kernel(c.minor);
        const auto features = LoopbackModule(kernel).features();
        ASSERT_TRUE(features) << features.error().message;
        EXPECT_EQ(features->adds_devices, c.adds) << c.minor;
        EXPECT_EQ(features->tells_readers, c.tells) << c.minor;
        EXPECT_EQ(features->streams, c.streams) << c.minor;
        EXPECT_EQ(kernel.open_descriptors(), 0u);
    }
}

TEST(LoopbackModule, AsksTheControlNodeWhenSysTellsNoVersion) {
    FakeModule newest(15);
    newest.tells_version = false;
    EXPECT_TRUE(LoopbackModule(newest).features()->streams);
    // 0.13 and 0.14 cannot be told apart then: write() works on both.
    FakeModule older(14);
    older.tells_version = false;
    EXPECT_FALSE(LoopbackModule(older).features()->streams);
}

TEST(LoopbackModule, MissingModuleSaysWhatToRun) {
    FakeModule kernel(15);
    kernel.loaded = false;
    const auto made = LoopbackModule(kernel).provide(10, "lobby");
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().kind, ErrorKind::unavailable);
    EXPECT_THAT(made.error().message, HasSubstr("apt install v4l2loopback-dkms"));
    EXPECT_THAT(made.error().message, HasSubstr("modprobe v4l2loopback video_nr=10"));
}

TEST(LoopbackModule, TooOldModuleIsRefused) {
    FakeModule kernel(12);
    kernel.version = "0.10.0";
    const auto made = LoopbackModule(kernel).provide(10, "lobby");
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().kind, ErrorKind::unsupported);
    EXPECT_THAT(made.error().message, HasSubstr("0.10.0 is too old"));
}

TEST(LoopbackModule, MakesADeviceWithFourBuffersExclusiveCapsAndTheCamerasName) {
    FakeModule kernel(13);
    const LoopbackModule module(kernel);
    const auto made = module.provide(10, "lobby");
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_TRUE(made->is_new);
    EXPECT_EQ(kernel.devices.at(10).card, "lobby");
    EXPECT_EQ(kernel.devices.at(10).max_buffers, 4);
    EXPECT_TRUE(kernel.devices.at(10).exclusive);
    EXPECT_FALSE(module.provide(10, "lobby")->is_new);  // it is there
    EXPECT_TRUE(module.remove(10));
    EXPECT_TRUE(kernel.devices.empty());
}

TEST(LoopbackModule, WithoutControlNodeAMissingDeviceNamesTheModprobeLine) {
    FakeModule kernel(12);
    const LoopbackModule module(kernel);
    const auto made = module.provide(10, "lobby");
    ASSERT_FALSE(made);
    EXPECT_THAT(made.error().message, HasSubstr("modprobe v4l2loopback video_nr=10 exclusive_caps=1 max_buffers=4"));
}

TEST(LoopbackModule, WithoutPermissionItSaysHowToGetIt) {
    FakeModule kernel(15);
    kernel.control_problem = EACCES;
    const LoopbackModule module(kernel);
    const auto made = module.provide(10, "lobby");
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().kind, ErrorKind::unauthorized);
    EXPECT_THAT(made.error().message, HasSubstr("chgrp video /dev/v4l2loopback"));
}

TEST(CheckLoopback, SaysBeforehandWhatWouldFailAndChangesNothing) {
    const auto said = [](FakeModule& kernel) {
        const auto good = check_loopback(10, "lobby", kernel);
        EXPECT_EQ(kernel.added, 0);
        EXPECT_EQ(kernel.open_descriptors(), 0u);
        return good ? std::string() : good.error().message;
    };
    FakeModule absent(15), old(12), forbidden(15), foreign(15), unreadable(15), ready(15), present(12);
    absent.loaded = false;
    EXPECT_THAT(said(absent), HasSubstr("modprobe v4l2loopback"));
    EXPECT_THAT(said(old), HasSubstr("modprobe -r v4l2loopback"));
    forbidden.control_problem = EACCES;
    EXPECT_THAT(said(forbidden), HasSubstr("chgrp video /dev/v4l2loopback"));
    foreign.plug(10).driver = "uvcvideo";
    EXPECT_THAT(said(foreign), HasSubstr("belongs to the driver 'uvcvideo'"));
    unreadable.plug(10);
    unreadable.open_problem = EACCES;
    EXPECT_THAT(said(unreadable), HasSubstr("usermod -aG video"));
    EXPECT_EQ(said(ready), "");
    present.plug(10).keep_format = true;
    EXPECT_EQ(said(present), "");
    EXPECT_TRUE(present.devices.at(10).keep_format);
    EXPECT_TRUE(present.calls.empty());
}

TEST(LoopbackModule, ANumberThatTheKernelCannotGiveIsNotKept) {
    FakeModule kernel(15);
    kernel.add_gives = 11;
    const LoopbackModule module(kernel);
    const auto made = module.provide(10, "lobby");
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().kind, ErrorKind::already_exists);
    EXPECT_TRUE(kernel.devices.empty());
}

TEST(LoopbackModule, ADeviceThatIsReadCannotBeRemoved) {
    FakeModule kernel(15);
    const LoopbackModule module(kernel);
    ASSERT_TRUE(module.provide(10, "lobby"));
    kernel.reader_comes(10);
    const auto removed = module.remove(10);
    ASSERT_FALSE(removed);
    EXPECT_EQ(removed.error().kind, ErrorKind::unavailable);
    kernel.reader_leaves(10);
    EXPECT_TRUE(module.remove(10));
}

}  // namespace
}  // namespace camrig::device
