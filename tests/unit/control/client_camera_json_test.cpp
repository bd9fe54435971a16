#include <limits>

#include <camrig/error.h>
#include <gtest/gtest.h>

#include "control/client/camera_json.h"
#include "core/world/camera_fields.h"
#include "core/world/camera_json.h"

// Every member under its own name of the protocol, in both directions: no two values here are the same, so that none
// can stand in for another.
namespace camrig::client {
namespace {

using nlohmann::json;

const json every_param = json::parse(R"({
    "place": "door", "size": [320, 200], "fps": "30000/1001", "vfov_deg": 41.5, "hfov_deg": 62.5,
    "intrinsics": {"fx": 301.5, "fy": 302.25, "cx": 150.5, "cy": 99.5}, "zoom": 2.5,
    "pose": {"position": [1.5, -2.5, 3.5], "look_at": [4.5, 5.5, 6.5], "pan_deg": 11.0, "tilt_deg": 12.0,
             "roll_deg": 13.0, "orientation": [0.1, 0.2, 0.3, 0.9]},
    "mount": {"actor": "anna", "node": "head"},
    "lens": {"model": "plumb_bob", "coefficients": [-0.25, 0.05, 0.001, -0.002, 0.01], "method": "cube",
             "filter": "bicubic"},
    "antialias": "ssaa2", "near": 0.125, "far": 80.0, "quality": "fast",
    "controls": {"auto_exposure": false, "exposure_ev": 1.25, "gain_db": 7.0, "auto_white_balance": true,
                 "white_balance_k": 4000.0, "brightness": 0.4, "contrast": 1.4, "saturation": 0.6},
    "code_strip": true,
    "outputs": [{"kind": "rtsp", "codec": "h264", "bitrate_kbps": 900, "key_interval_s": 0.75, "preset": "faster",
                 "profile": "main"},
                {"kind": "v4l2", "number": 7, "format": "MJPG", "subsampling": "4:2:0"}, {"kind": "mjpeg", "quality": 70}]})");

CameraOptions every_option() {
    CameraOptions options;
    options.place = "door";
    options.size = {320, 200};
    options.fps = Rate(30000, 1001);
    options.vfov_deg = 41.5;
    options.hfov_deg = 62.5;
    options.intrinsics = {301.5, 302.25, 150.5, 99.5};
    options.zoom = 2.5;
    options.position = {1.5, -2.5, 3.5};
    options.look_at = {4.5, 5.5, 6.5};
    options.pan_deg = 11;
    options.tilt_deg = 12;
    options.roll_deg = 13;
    options.orientation = {0.1, 0.2, 0.3, 0.9};
    options.mount = Mount{"anna", "head"};
    options.lens = Lens{"plumb_bob", {-0.25, 0.05, 0.001, -0.002, 0.01}, "cube", "bicubic"};
    options.antialias = "ssaa2";
    options.near = 0.125;
    options.far = 80;
    options.quality = "fast";
    options.controls = Controls{false, 1.25, 7.0, true, 4000.0, 0.4, 1.4, 0.6};
    options.code_strip = true;
    options.outputs = {Output{.kind = "rtsp",
                              .codec = "h264",
                              .bitrate_kbps = 900,
                              .key_interval_s = 0.75,
                              .preset = "faster",
                              .profile = "main"},
                       Output{.kind = "v4l2", .number = 7, .format = "MJPG", .subsampling = "4:2:0"},
                       Output{.kind = "mjpeg", .quality = 70}};
    return options;
}

/// An answer to camera.get with what was given and what the rig adds; parameters that are not above as the rig tells
/// them of a new camera.
json every_answer() {
    json answer = camera_to_json(world::CameraSpec{});
    answer.update(every_param);
    answer.erase("place");
    answer["name"] = "lobby";
    answer["pose"].erase("look_at");
    answer["world_pose"] = {{"position", {21.5, 22.5, 23.5}},
                            {"orientation", {0.9, 0.3, 0.2, 0.1}},
                            {"pan_deg", 31.0},
                            {"tilt_deg", 32.0},
                            {"roll_deg", 33.0}};
    answer["shown_intrinsics"] = {{"fx", 51.0}, {"fy", 52.0}, {"cx", 53.0}, {"cy", 54.0}};
    answer["id"] = 41;
    answer["sequence"] = 42;
    answer["readers"] = 43;
    answer["applied_ns"] = 44;
    answer["arrives_ns"] = 45;
    return answer;
}

void expect_pose(const Pose& pose, const json& expected) {
    EXPECT_EQ(json(pose.position), expected["position"]);
    EXPECT_EQ(json(pose.orientation), expected["orientation"]);
    EXPECT_EQ(pose.pan_deg, expected["pan_deg"]);
    EXPECT_EQ(pose.tilt_deg, expected["tilt_deg"]);
    EXPECT_EQ(pose.roll_deg, expected["roll_deg"]);
}

TEST(CameraJson, EveryOptionIsSentUnderItsName) {
    EXPECT_EQ(params_of(every_option()), every_param);
    EXPECT_EQ(params_of({}), json::object()) << "what is not given is not sent";
}

TEST(CameraJson, AnEmptyQualityAndInnerOptionalsThatAreEmptyAreSentAsNull) {
    CameraOptions options;
    options.quality = "";
    options.mount.emplace();
    options.backdrop.emplace();
    options.sensor.emplace();
    EXPECT_EQ(params_of(options),
              (json{{"quality", nullptr}, {"mount", nullptr}, {"backdrop", nullptr}, {"sensor", nullptr}}));
}

TEST(CameraJson, EveryMemberOfAnAnswerIsReadFromItsName) {
    const json answer = every_answer();
    const CameraState state = camera_state_of(answer);
    // What can be given again is compared as it would be sent.
    CameraOptions options = state.options();
    options.outputs = state.outputs;
    json sent = params_of(options);
    json expected = answer;
    for (const auto& entry : world::camera_fields())
        if (entry.field.by == Field::By::rig) expected.erase(entry.field.name);
    for (const char* of_options : {"name", "vfov_deg", "hfov_deg"}) expected.erase(of_options);
    for (const char* angle : {"pan_deg", "tilt_deg", "roll_deg"}) expected["pose"].erase(angle);
    EXPECT_EQ(sent, expected);
    EXPECT_EQ(state.name, "lobby");
    EXPECT_EQ(state.vfov_deg, 41.5);
    EXPECT_EQ(state.hfov_deg, 62.5);
    expect_pose(state.pose, answer["pose"]);
    expect_pose(state.world_pose, answer["world_pose"]);
    EXPECT_EQ(state.shown_intrinsics.fx, 51.0);
    EXPECT_EQ(state.shown_intrinsics.cy, 54.0);
    EXPECT_EQ(state.id, 41);
    EXPECT_EQ(state.sequence, 42);
    EXPECT_EQ(state.readers, 43);
    EXPECT_EQ(state.applied_ns, 44);
    EXPECT_EQ(state.arrives_ns, 45);
}

TEST(CameraJson, NullAndWhatIsMissingHaveTheirMeaning) {
    json answer = every_answer();
    answer["quality"] = nullptr;
    answer["mount"] = nullptr;
    answer["fps"] = 12.5;
    answer["lens"] = {{"model", "pinhole"}, {"coefficients", json::array()}};
    answer["controls"] = {{"gain_db", nullptr}};
    answer["outputs"] = {{{"kind", "mjpeg"}}};
    const CameraState state = camera_state_of(answer);
    EXPECT_EQ(state.quality, "");
    EXPECT_FALSE(state.mount);
    EXPECT_EQ(state.fps, Rate(25, 2));
    EXPECT_EQ(state.lens.method + " " + state.lens.filter, "auto auto");
    EXPECT_FALSE(state.controls.gain_db);
    EXPECT_FALSE(state.outputs.at(0).quality);

    answer["mount"] = {{"actor", "anna"}};
    EXPECT_EQ(camera_state_of(answer).mount->node, "");
}

TEST(CameraJson, AnAnswerThatLacksSomethingIsAnInternalError) {
    const json whole = every_answer();
    for (const auto& [key, value] : whole.items()) {
        json answer = whole;
        answer.erase(key);
        EXPECT_THROW(camera_state_of(answer), Error) << key;
    }
    EXPECT_THROW(world_status_of(json::object()), Error);
}

TEST(CameraJson, EveryMemberOfAWorldIsReadFromItsName) {
    const WorldStatus world = world_status_of(json::parse(R"({
        "scene": "hall", "scene_file": "hall.json", "mode": "lockstep", "overload": "slow", "quality": "beautiful",
        "paused": true, "world_ns": 51, "step_ns": 52, "seed": 18446744073709551615, "state_ns": 53,
        "state_hash": "00ab", "objects": 54, "actors": 55, "cameras": 56, "places": ["door", "roof"],
        "applied_ns": 57})"));
    EXPECT_EQ(world.scene, "hall");
    EXPECT_EQ(world.scene_file, "hall.json");
    EXPECT_EQ(world.mode, "lockstep");
    EXPECT_EQ(world.overload, "slow");
    EXPECT_EQ(world.quality, "beautiful");
    EXPECT_TRUE(world.paused);
    EXPECT_EQ(world.world_ns, 51);
    EXPECT_EQ(world.step_ns, 52);
    EXPECT_EQ(world.seed, std::numeric_limits<std::uint64_t>::max());
    EXPECT_EQ(world.state_ns, 53);
    EXPECT_EQ(world.state_hash, "00ab");
    EXPECT_EQ(world.objects, 54);
    EXPECT_EQ(world.actors, 55);
    EXPECT_EQ(world.cameras, 56);
    EXPECT_EQ(world.places, (std::vector<std::string>{"door", "roof"}));
    EXPECT_EQ(world.applied_ns, 57);
}

}  // namespace
}  // namespace camrig::client
