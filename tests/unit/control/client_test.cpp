#include <fstream>

#include <camrig/client.h>
#include <gmock/gmock.h>

#include "tests/unit/control/server_harness.h"

namespace camrig::control {
namespace {

using testing::AllOf;
using testing::HasSubstr;

client::Rig rig_at(const std::string& control) {
    return client::connect({.control = control, .token = {}});
}

/// The kind of the Error that `action` throws, and its words.
template <typename Action>
std::string failure_of(Action action) {
    try {
        action();
    } catch (const client::Error& why) {
        return why.kind() + ": " + why.what();
    }
    return "no error";
}

/// Another value than the default for everything that can be given.
client::CameraOptions every_option() {
    client::CameraOptions options;
    options.size = {320, 200};
    options.fps = client::Rate(30000, 1001);
    options.intrinsics = {301.5, 302.25, 150, 99};
    options.zoom = 2.0;
    options.position = {1, -2, 3.5};
    options.orientation = {0, 0, 0.6, 0.8};
    options.mount = client::Mount{"anna", "head"};
    options.lens = client::Lens{"plumb_bob", {-0.2, 0.05, 0.001, -0.002, 0.01}, "cube", "bicubic"};
    options.antialias = "ssaa2";
    options.near = 0.25;
    options.far = 80.0;
    options.quality = "fast";
    options.controls = client::Controls{.auto_exposure = false, .exposure_ev = 1.5, .saturation = 0.5};
    options.code_strip = true;
    client::Output stream{.kind = "rtsp", .codec = "h264", .bitrate_kbps = 900, .key_interval_s = 1.0};
    options.outputs = {stream, client::Output{.kind = "mjpeg", .quality = 70}};
    return options;
}

void expect_same(const client::CameraState& state, const client::CameraOptions& options) {
    EXPECT_EQ(state.size, *options.size);
    EXPECT_EQ(state.fps, *options.fps);
    EXPECT_DOUBLE_EQ(state.intrinsics.fx, options.intrinsics->fx);
    EXPECT_DOUBLE_EQ(state.intrinsics.fy, options.intrinsics->fy);
    EXPECT_DOUBLE_EQ(state.intrinsics.cx, options.intrinsics->cx);
    EXPECT_DOUBLE_EQ(state.intrinsics.cy, options.intrinsics->cy);
    EXPECT_DOUBLE_EQ(state.zoom, *options.zoom);
    EXPECT_EQ(state.pose.position, *options.position);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(state.pose.orientation[i], (*options.orientation)[i], 1e-12);
    ASSERT_TRUE(state.mount);
    EXPECT_EQ(state.mount->actor + "/" + state.mount->node, (*options.mount)->actor + "/" + (*options.mount)->node);
    EXPECT_EQ(state.lens.model, options.lens->model);
    EXPECT_EQ(state.lens.coefficients, options.lens->coefficients);
    EXPECT_EQ(state.lens.method, options.lens->method);
    EXPECT_EQ(state.lens.filter, options.lens->filter);
    EXPECT_EQ(state.antialias, *options.antialias);
    EXPECT_DOUBLE_EQ(state.near, *options.near);
    EXPECT_DOUBLE_EQ(state.far, *options.far);
    EXPECT_EQ(state.quality, *options.quality);
    EXPECT_EQ(state.controls.auto_exposure, false);
    EXPECT_EQ(state.controls.exposure_ev, 1.5);
    EXPECT_EQ(state.controls.saturation, 0.5);
    EXPECT_TRUE(state.code_strip);
}

TEST(Client, WhatACameraIsGivenIsWhatItHas) {
    ServerHarness harness;
    const auto rig = rig_at(harness.path);
    const auto options = every_option();
    const auto state = rig.create_camera("lobby", options).get();
    expect_same(state, options);
    ASSERT_EQ(state.outputs.size(), 2u);
    EXPECT_EQ(state.outputs[0].kind, "rtsp");
    EXPECT_EQ(state.outputs[0].bitrate_kbps, 900);
    EXPECT_EQ(state.outputs[1].quality, 70);
}

TEST(Client, TheOptionsOfAStateMakeTheSameCameraAgainWithoutItsOutputs) {
    ServerHarness harness;
    const auto rig = rig_at(harness.path);
    const auto options = every_option();
    const auto first = rig.create_camera("lobby", options).get();
    const auto twin = rig.create_camera("twin", first.options()).get();
    expect_same(twin, options);
    EXPECT_TRUE(twin.outputs.empty());
}

TEST(Client, ActorsObjectsEventsAndFaultsHaveTypes) {
    ServerHarness harness;
    const auto rig = rig_at(harness.path);
    client::ActorOptions guest;
    guest.object_class = "person";
    guest.position = client::Vector3{1, -2, 0.5};
    guest.scale = 2;
    guest.behaviour = nlohmann::json{{"type", "wander"}, {"area", "hall"}};
    const auto spawned = rig.spawn_actor("guest", "person_1", guest);
    EXPECT_EQ(spawned.position, (client::Vector3{1, -2, 0.5}));
    EXPECT_EQ(spawned.object_class + " " + spawned.behaviour, "person wander");
    EXPECT_EQ(spawned.applied_ns, 10);
    client::ActorChanges changes;
    changes.attach = client::Attachment{"anna", "hand"};
    EXPECT_EQ(rig.set_actor("guest", changes).name, "guest");
    EXPECT_EQ(rig.actors().at(0).name, "anna");
    client::Steering anna;
    anna.name = "anna";
    anna.velocity = client::Vector3{1.2, 0, 0};
    EXPECT_EQ(rig.steer_actors({anna}), 10);
    anna.position = anna.velocity;
    EXPECT_THAT(failure_of([&] { rig.steer_actors({anna}); }), HasSubstr("either velocity or position"));

    client::ObjectChanges hide;
    hide.hidden = true;
    EXPECT_TRUE(rig.set_object("table", hide).hidden);
    EXPECT_EQ(rig.spawn_object("box_2", "box").model, "box");
    EXPECT_EQ(rig.objects().at(0).object_class, "furniture");
    EXPECT_FALSE(rig.object("table").box) << "its model is empty";

    EXPECT_EQ(rig.add_event("alarm", {{"at_s", 3}}, nlohmann::json::array(), 2).limit, 2);
    EXPECT_EQ(rig.act({{{"action", "light"}, {"light", "lamp"}, {"intensity", 0}}}), 10);
    EXPECT_EQ(rig.events().at(0).when, "every_s");
    const client::EventLog log = rig.wait_events(4, std::chrono::seconds(0));
    EXPECT_EQ(log.last, 5);
    EXPECT_EQ(log.events.at(0).event, "alarm");
    EXPECT_EQ(log.events.at(0).data, nlohmann::json::parse(R"([{"level": 2}])"));

    rig.create_camera("lobby");
    client::FaultOptions lost;
    lost.severity = 0.5;
    lost.params = nlohmann::json{{"burst_frames", 8}};
    const auto fault = rig.set_fault("lobby", "drop", lost);
    EXPECT_EQ(fault.severity, 0.5);
    EXPECT_EQ(fault.params.at("burst_frames"), 8);
    EXPECT_FALSE(fault.end_ns);
    EXPECT_EQ(rig.faults().at(0).id, fault.id);
}

TEST(Client, WhatIsNotGivenStaysAndNullTakesACameraOffItsMount) {
    ServerHarness harness;
    const auto rig = rig_at(harness.path);
    const auto camera = rig.create_camera("lobby", every_option());
    client::CameraOptions change;
    change.mount.emplace();
    change.quality = "";
    const auto state = camera.set(change);
    EXPECT_FALSE(state.mount);
    EXPECT_EQ(state.quality, "");
    EXPECT_EQ(state.size, (client::Size{320, 200}));
    EXPECT_EQ(state.lens.model, "plumb_bob");
    client::CameraOptions zoom;
    zoom.zoom = 4.0;
    EXPECT_EQ(camera.set(zoom, 2.5).arrives_ns, 2'500'000'000);
}

TEST(Client, RatesAreTakenAsTheDecimalsTheyAreWrittenAs) {
    EXPECT_EQ(client::Rate(29.97), client::Rate(2997, 100));
    EXPECT_EQ(client::Rate(25), client::Rate(25, 1));
    EXPECT_THAT(failure_of([] { client::Rate(1e9); }), HasSubstr("invalid_argument"));
}

TEST(Client, ErrorsKeepTheirKindAndTheConnectionStaysGood) {
    ServerHarness harness;
    const auto rig = rig_at(harness.path);
    const auto camera = rig.create_camera("lobby");
    EXPECT_THAT(failure_of([&] { rig.camera("nobody"); }), HasSubstr("not_found: "));
    EXPECT_THAT(failure_of([&] { rig.create_camera("lobby"); }), HasSubstr("already_exists: "));
    client::CameraOptions wrong;
    wrong.size = {1, 1};
    EXPECT_THAT(failure_of([&] { camera.set(wrong); }), HasSubstr("invalid_argument: "));
    EXPECT_THAT(failure_of([&] { camera.snapshot("picture.gif"); }), HasSubstr("invalid_argument: "));
    EXPECT_EQ(rig.cameras().size(), 1u);
    camera.remove();
    EXPECT_THAT(failure_of([&] { camera.get(); }), HasSubstr("not_found: "));
}

TEST(Client, NobodyThereIsUnavailableAndSaysWhatToDo) {
    TemporaryFolder folder;
    EXPECT_THAT(failure_of([&] { rig_at((folder / "s").string()); }),
                AllOf(HasSubstr("unavailable: "), HasSubstr("camrig serve")));
}

TEST(Client, CallsOfTwoThreadsDoNotWaitForEachOther) {
    ServerHarness harness;
    const auto rig = rig_at(harness.path);
    harness.rig.hold_steps();
    std::thread stepper([&] { rig.step(std::chrono::milliseconds(200)); });
    EXPECT_TRUE(eventually([&] { return harness.rig.held() == 1; }));
    EXPECT_EQ(rig.status().cameras, 0);  // would wait for ever behind the step
    harness.rig.release();
    stepper.join();
    EXPECT_EQ(harness.rig.last_step_ns(), 200'000'000);
}

TEST(Client, ARigThatComesBackIsReachedAgain) {
    ServerHarness harness;
    const auto rig = rig_at(harness.path);
    harness.server.reset();
    EXPECT_THAT(failure_of([&] { rig.status(); }), HasSubstr("unavailable: "));
    ControlServerOptions options;
    options.unix_path = harness.path;
    options.rpc = &harness.rpc;
    harness.server = std::move(*ControlServer::create(std::move(options)));
    EXPECT_EQ(rig.status().cameras, 0);
}

TEST(Client, FramesComeWithTheirInstantAndAsTheyWereAskedFor) {
    ServerHarness harness;
    const auto rig = rig_at(harness.path);
    const auto camera = rig.create_camera("lobby");
    harness.rig.set_picture_bytes(1000);
    const auto frame = camera.frame({.kind = "color", .min_ns = 0, .format = "jpeg", .quality = 55});
    EXPECT_EQ(frame.data.size(), 1000u);
    EXPECT_EQ(frame.camera, "lobby");
    EXPECT_EQ(frame.format, "jpeg");
    camera.frame({.kind = "color", .min_ns = 77, .format = "png"});
    EXPECT_EQ(harness.rig.last_fetch().min_ns, 77);
}

TEST(Client, CamerasOfAFileAreMadeInOrderUntilOneCannotBe) {
    ServerHarness harness;
    const auto rig = rig_at(harness.path);
    const auto file = harness.folder / "cameras.json";
    std::ofstream(file) << R"({"cameras": [{"name": "left"}, {"name": "right", "fps": 10}]})";
    const auto made = rig.create_cameras(file);
    ASSERT_EQ(made.size(), 2u);
    EXPECT_EQ(made[1].name(), "right");
    EXPECT_EQ(made[1].get().fps, client::Rate(10));
    std::ofstream(file) << R"([{"name": "third"}, {"name": "left"}])";
    EXPECT_THAT(failure_of([&] { rig.create_cameras(file); }),
                AllOf(HasSubstr("already_exists: "), HasSubstr("cameras.json: cameras[1]")));
    EXPECT_EQ(rig.cameras().size(), 3u);
}

TEST(Client, ATokenOpensTheDoorOverTcp) {
    ServerHarness harness({}, true, "open sesame");
    const std::string place = "127.0.0.1:" + std::to_string(harness.server->tcp_port());
    EXPECT_EQ(client::connect({.control = place, .token = "open sesame"}).cameras().size(), 0u);
    EXPECT_THAT(failure_of([&] { client::connect({.control = place, .token = "wrong"}); }),
                HasSubstr("unauthorized: "));
}

}  // namespace
}  // namespace camrig::control
