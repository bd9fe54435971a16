#include "tools/camrig/cli.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>

#include "core/world/camera_fields.h"
#include "tests/temporary_folder.h"
#include "tests/unit/control/server_harness.h"
#include "tools/camrig/cli_field_options.h"

namespace camrig::control::cli_test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

struct Outcome {
    int code = 0;
    std::string out, err;
    cli::ServeOptions serve;
    cli::PythonCommand python;
    std::vector<std::string> view;
};

Outcome run(std::vector<std::string> arguments) {
    Outcome result;
    std::ostringstream out, err;
    const auto serve = [&](const cli::ServeOptions& options) {
        result.serve = options;
        return 0;
    };
    const auto python = [&](const cli::PythonCommand& command) {
        result.python = command;
        return 7;
    };
    const auto view = [&](const std::vector<std::string>& words) {
        result.view = words;
        return 8;
    };
    result.code =
        cli::run_cli(std::move(arguments), {.serve = serve, .out = out, .err = err, .python = python, .view = view});
    result.out = out.str();
    result.err = err.str();
    return result;
}

/// The command line at a fake rig.
class Cli : public testing::Test {
protected:
    Outcome at_rig(std::vector<std::string> arguments) {
        arguments.insert(arguments.end(), {"--control", harness.path});
        return run(std::move(arguments));
    }
    json json_of(std::vector<std::string> arguments) {
        arguments.push_back("--json");
        const Outcome done = at_rig(std::move(arguments));
        EXPECT_EQ(done.code, 0) << done.err;
        return done.code == 0 ? json::parse(done.out) : json::object();
    }

    ServerHarness harness;
};

TEST(CliView, GivesTheWindowItsPlaceAndTheFileOfTheArrangement) {
    const Outcome done = run({"view", "--control", "/run/rig", "--file", "mine.json", "--height", "600"});
    EXPECT_EQ(done.code, 8);
    EXPECT_THAT(done.view, testing::ElementsAre("/run/rig", "", "mine.json", "1280", "600"));
    EXPECT_EQ(run({"view", "--width", "3"}).code, 2);
}

TEST_F(Cli, CameraCreateTakesEveryOption) {
    const json camera = json_of({"camera",     "create",       "lobby",
                                 "--size",     "322x244",      "--fps",
                                 "30000/1001", "--intrinsics", "300,310,150.5,120",
                                 "--position", "-1,2,3.5",     "--look-at",
                                 "4,5,1",      "--near",       "0.1",
                                 "--far",      "100",          "--quality",
                                 "fast",       "--code-strip", "--v4l2",
                                 "3",          "--device",     "5",
                                 "--rtsp",     "h264",         "--mjpeg"});
    EXPECT_EQ(camera["size"], json({322, 244}));
    EXPECT_EQ(camera["fps"], "30000/1001");
    EXPECT_EQ(camera["intrinsics"]["fy"], 310);
    EXPECT_EQ(camera["pose"]["position"], json({-1, 2, 3.5}));
    EXPECT_EQ(camera["near"], 0.1);
    EXPECT_EQ(camera["far"], 100);
    EXPECT_EQ(camera["quality"], "fast");
    EXPECT_EQ(camera["code_strip"], true);
    EXPECT_EQ(camera["outputs"].size(), 4u);
    EXPECT_TRUE(camera.contains("applied_ns"));
}

TEST_F(Cli, TheOptionsOfAnRtspOutput) {
    const json h264 =
        json_of({"camera", "create", "a", "--position", "1,2,3", "--rtsp", "h264", "--rtsp-bitrate-kbps", "3000",
                 "--rtsp-key-interval-s", "0.5", "--rtsp-preset", "veryfast", "--rtsp-profile", "high"});
    EXPECT_EQ(h264["outputs"], json::parse(R"([{"kind": "rtsp", "codec": "h264", "bitrate_kbps": 3000,
        "key_interval_s": 0.5, "preset": "veryfast", "profile": "high"}])"));
    const json mjpeg = json_of({"camera", "set", "a", "--rtsp", "mjpeg", "--rtsp-quality", "40"});
    EXPECT_EQ(mjpeg["outputs"], json::parse(R"([{"kind": "rtsp", "codec": "mjpeg", "quality": 40}])"));

    const json sub = json_of({"camera", "set", "a", "--rtsp", "h265", "--rtsp-stream", "sub", "--rtsp-size", "320x240",
                              "--rtsp-fps", "25/2"});
    EXPECT_EQ(sub["outputs"], json::parse(R"([{"kind": "rtsp", "codec": "h265", "stream": "sub", "size": [320, 240],
        "fps": "25/2"}])"));
    const Outcome no_output = run({"camera", "set", "a", "--rtsp-preset", "fast"});
    EXPECT_EQ(no_output.code, 2);
    EXPECT_THAT(no_output.err, HasSubstr("--rtsp"));
}

TEST_F(Cli, TheOptionsOfOtherOutputs) {
    const json camera =
        json_of({"camera", "create", "a", "--position", "1,2,3", "--device", "5", "--subsampling", "4:2:0"});
    EXPECT_EQ(camera["outputs"], json::parse(R"([{"kind": "device", "number": 5, "subsampling": "4:2:0"}])"));
    EXPECT_THAT(at_rig({"camera", "list"}).out, AllOf(HasSubstr("DEVICE"), HasSubstr("  /dev/video5\n")));
    EXPECT_EQ(run({"camera", "set", "a", "--subsampling", "4:2:0"}).code, 2);
    const json loopback =
        json_of({"camera", "set", "a", "--v4l2", "6", "--v4l2-format", "MJPG", "--v4l2-subsampling", "4:2:0"});
    EXPECT_EQ(loopback["outputs"],
              json::parse(R"([{"kind": "v4l2", "number": 6, "format": "MJPG", "subsampling": "4:2:0"}])"));
    EXPECT_EQ(json_of({"camera", "set", "a", "--mjpeg", "--mjpeg-quality", "70"})["outputs"],
              json::parse(R"([{"kind": "mjpeg", "quality": 70}])"));
}

TEST_F(Cli, ZoomAndControlsAreSetOneByOne) {
    const json camera = json_of({"camera", "create", "lobby", "--position", "1,2,3", "--set-ctrl", "exposure_ev=-1.5",
                                 "--set-ctrl", "saturation=0"});
    EXPECT_EQ(camera["controls"]["exposure_ev"], -1.5);
    EXPECT_EQ(camera["controls"]["auto_exposure"], false);
    EXPECT_EQ(camera["controls"]["saturation"], 0);
    const json after = json_of({"camera", "set", "lobby", "--zoom", "2", "--set-ctrl", "auto_exposure=true"});
    EXPECT_EQ(after["zoom"], 2);
    EXPECT_EQ(after["arrives_ns"], 0);
    EXPECT_EQ(json_of({"camera", "set", "lobby", "--zoom", "3", "--seconds", "1.5"})["arrives_ns"], 1'500'000'000);
    EXPECT_EQ(after["controls"]["auto_exposure"], true);
    EXPECT_EQ(after["controls"]["saturation"], 0);
    EXPECT_NEAR(after["intrinsics"]["fx"].get<double>(), 2 * camera["intrinsics"]["fx"].get<double>(), 1e-9);
}

TEST_F(Cli, AWordThatIsNoCommandIsNamed) {
    const Outcome top = run({"serv", "scenes/hall.json"});
    EXPECT_EQ(top.code, 2);
    EXPECT_THAT(top.err, AllOf(HasSubstr("'serv'"), HasSubstr("serve"), HasSubstr("camera")));
    const Outcome inner = run({"camera", "destroy", "a"});
    EXPECT_EQ(inner.code, 2);
    EXPECT_THAT(inner.err, AllOf(HasSubstr("'destroy'"), HasSubstr("delete"), Not(HasSubstr("serve"))));
    EXPECT_THAT(run({"world"}).err, AllOf(HasSubstr("world: a command is missing"), HasSubstr("pause")));
}

TEST_F(Cli, AnglesAndHorizontalFieldsOfViewAndPlaces) {
    const json camera = json_of({"camera", "create", "a", "--hfov-deg", "70", "--position", "0,0,2", "--pan-deg", "-90",
                                 "--tilt-deg", "-10", "--fps", "29.97"});
    EXPECT_NEAR(camera["hfov_deg"].get<double>(), 70, 1e-9);
    EXPECT_NEAR(camera["pose"]["pan_deg"].get<double>(), -90, 1e-9);
    EXPECT_NEAR(camera["pose"]["tilt_deg"].get<double>(), -10, 1e-9);
    EXPECT_EQ(camera["fps"], "2997/100");
    EXPECT_EQ(json_of({"camera", "create", "b", "--place", "door", "--vfov-deg", "40"})["name"], "b");
}

TEST_F(Cli, NoneTakesAnObjectAwayAndOtherWordsSaySo) {
    const json made = json_of(
        {"camera", "create", "a", "--position", "0,0,2", "--ptz", "preset=ideal", "--clock", "drift_ppb=50000"});
    EXPECT_TRUE(made["clock"].is_object());
    EXPECT_TRUE(made["ptz"].is_object());
    for (const char* field : {"clock", "ptz"}) {
        const Outcome null = run({"camera", "set", "a", std::string("--") + field, "null"});
        EXPECT_EQ(null.code, 2);
        EXPECT_THAT(null.err, HasSubstr("or none, to take it away")) << field;
        EXPECT_TRUE(json_of({"camera", "set", "a", std::string("--") + field, "none"})[field].is_null()) << field;
    }
    EXPECT_THAT(run({"camera", "set", "--help"}).out, HasSubstr("none: none, it is right"));
}

TEST_F(Cli, PartsOfAnObjectMayBeTheirWordOrNone) {
    const json made = json_of({"camera", "create", "a", "--position", "0,0,2", "--sensor", "preset=imx290", "--sensor",
                               "exposure_s=auto", "--sensor", "lux=none", "--sensor", "gain_db=3"})["sensor"];
    EXPECT_EQ(made["preset"], "imx290");
    EXPECT_EQ(made["exposure_s"], "auto");
    EXPECT_TRUE(made["lux"].is_null());
    EXPECT_EQ(made["gain_db"], 3);
    for (const char* wrong : {"exposure_s=never", "gain_db=auto", "gain_db=none", "lux=null", "lux=", "lux"})
        EXPECT_EQ(run({"camera", "set", "a", "--sensor", wrong}).code, 2) << wrong;
}

TEST_F(Cli, ATourHasPresetsAndOneDwellAndSpeedForAll) {
    json_of({"camera", "create", "dome", "--position", "0,0,2", "--ptz", "preset=ideal"});
    const json made =
        json_of({"ptz", "tour-set", "dome", "round", "door", "desk", "--dwell", "10", "--speed", "0.5"})["tours"];
    EXPECT_EQ(made, json::parse(R"({"round": [{"preset": "door", "dwell_s": 10.0, "speed": 0.5},
                                              {"preset": "desk", "dwell_s": 10.0, "speed": 0.5}]})"));
    EXPECT_THAT(at_rig({"ptz", "status", "dome"}).out, ContainsRegex("tour round +door for 10 s, desk for 10 s"));
}

TEST_F(Cli, AFaultsOwnParametersAreOptions) {
    json_of({"camera", "create", "a", "--position", "0,0,2"});
    const json set = json_of({"fault", "set", "a", "dead_rows", "--severity", "0.5", "--share", "0.1", "--columns",
                              "true", "--start-s", "2", "--end-s", "3.5", "--seed", "9"});
    EXPECT_EQ(set["params"], json::parse(R"({"share": 0.1, "columns": true})"));
    EXPECT_EQ(set["severity"], 0.5);
    EXPECT_EQ(set["start_ns"], 2'000'000'000);
    EXPECT_EQ(set["end_ns"], 3'500'000'000);
    EXPECT_EQ(set["seed"], 9);
    EXPECT_THAT(at_rig({"fault", "list"}).out, ContainsRegex("dead_rows +0.5 +2 s +3.5 s"));
    EXPECT_EQ(json_of({"fault", "clear", "--id", "1"})["cleared"], 1);
    EXPECT_THAT(at_rig({"fault", "list"}).out, HasSubstr("no camera fails"));
    EXPECT_NE(at_rig({"fault", "set", "a", "mood"}).code, 0);
}

TEST_F(Cli, SetKeepsWhatAPoseLeavesOpen) {
    json_of({"camera", "create", "a", "--position", "1,2,3", "--pan-deg", "30", "--tilt-deg", "-5"});
    json camera = json_of({"camera", "set", "a", "--pan-deg", "60"});
    EXPECT_EQ(camera["pose"]["position"], json({1, 2, 3}));
    EXPECT_NEAR(camera["pose"]["pan_deg"].get<double>(), 60, 1e-9);
    EXPECT_NEAR(camera["pose"]["tilt_deg"].get<double>(), -5, 1e-9);
    camera = json_of({"camera", "set", "a", "--position", "4,5,6"});
    EXPECT_EQ(camera["pose"]["position"], json({4, 5, 6}));
    EXPECT_NEAR(camera["pose"]["pan_deg"].get<double>(), 60, 1e-9);
}

TEST_F(Cli, FilesOfCamerasAreOneAListOrAnObject) {
    TemporaryFolder folder;
    const auto file = [&](const std::string& text) {
        const auto path = folder / "cameras.json";
        std::ofstream(path) << text;
        return path.string();
    };
    EXPECT_EQ(json_of({"camera", "create", "--file", file(R"({"name":"a"})")})["cameras"].size(), 1u);
    EXPECT_EQ(json_of({"camera", "create", "--file", file(R"([{"name":"b"},{"name":"c"}])")})["cameras"].size(), 2u);
    EXPECT_EQ(json_of({"camera", "create", "--file", file(R"({"cameras":[{"name":"d"}]})")})["cameras"].size(), 1u);
    EXPECT_EQ(json_of({"camera", "list"})["cameras"].size(), 4u);
    const Outcome twice = at_rig({"camera", "create", "--file", file(R"([{"name":"e"},{"name":"a"}])")});
    EXPECT_EQ(twice.code, 1);
    EXPECT_THAT(twice.err, AllOf(HasSubstr("cameras.json: cameras[1]"), HasSubstr("those before it were made")));
    const auto changed =
        json_of({"camera", "create", "--file", file(R"([{"name":"a","fps":5},{"name":"f"}])"), "--replace"});
    EXPECT_EQ(changed["cameras"].size(), 2u);
    EXPECT_EQ(json_of({"camera", "get", "a"})["fps"], 5);
    const Outcome none = at_rig({"camera", "get", "nobody", "--json"});
    EXPECT_EQ(none.code, 1);
    EXPECT_EQ(json::parse(none.err)["error"]["kind"], "not_found");
    EXPECT_THAT(json::parse(none.err)["error"]["message"].get<std::string>(), HasSubstr("nobody"));
    const Outcome unknown = at_rig({"camera", "take", "--json"});
    EXPECT_EQ(unknown.code, 2);
    EXPECT_EQ(json::parse(unknown.err)["error"]["kind"], "invalid_argument");
    EXPECT_THAT(json::parse(unknown.err)["error"]["message"].get<std::string>(), HasSubstr("no command 'take'"));
    EXPECT_EQ(at_rig({"camera", "create", "--file", file("{")}).code, 1);
    EXPECT_THAT(at_rig({"camera", "create", "--file", file("7")}).err, HasSubstr("must be a camera"));
    EXPECT_THAT(at_rig({"camera", "create", "--file", (folder / "none").string()}).err, HasSubstr("cannot be read"));
}

TEST_F(Cli, WhatCameraGetPrintsMakesACameraAgain) {
    TemporaryFolder folder;
    json_of({"camera", "create", "lobby", "--position", "1,2,3", "--look-at", "4,5,1", "--hfov-deg", "71.3"});
    const std::string file = (folder / "lobby.json").string();
    std::ofstream(file) << at_rig({"camera", "get", "lobby", "--json"}).out;
    json copy = json_of({"camera", "create", "copy", "--file", file})["cameras"][0];
    json lobby = json_of({"camera", "get", "lobby"});
    for (const char* key : {"size", "fps", "intrinsics", "lens", "near", "far", "quality", "outputs"})
        EXPECT_EQ(copy[key], lobby[key]) << key;
    EXPECT_EQ(copy["pose"]["position"], lobby["pose"]["position"]);
    for (std::size_t i = 0; i < 4; ++i)
        EXPECT_NEAR(copy["pose"]["orientation"][i], lobby["pose"]["orientation"][i].get<double>(), 1e-15);
    at_rig({"camera", "delete", "lobby"});
    EXPECT_EQ(json_of({"camera", "create", "--file", file})["cameras"][0]["name"], "lobby");
    std::ofstream(file) << R"([{"name":"x"},{"name":"y"}])";
    EXPECT_EQ(at_rig({"camera", "create", "z", "--file", file}).code, 2);
}

TEST_F(Cli, ACalibrationComesOutAsItWentIn) {
    TemporaryFolder folder;
    const auto in = folder / "real.yml";
    std::ofstream(in) << "%YAML:1.0\n---\nimage_width: 752\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n"
                         "   rows: 3\n   cols: 3\n   dt: d\n"
                         "   data: [ 458.65400000000005, 0., 367.215, 0., 457.296, 248.375, 0., 0., 1. ]\n";
    const json camera = json_of({"camera", "create", "real", "--calibration", in.string()});
    EXPECT_EQ(camera["size"], json({752, 480}));
    EXPECT_EQ(camera["intrinsics"]["fx"], 458.65400000000005);
    EXPECT_EQ(camera["intrinsics"]["cy"], 248.375);
    const std::string text = at_rig({"camera", "calibration", "real"}).out;
    EXPECT_THAT(text, HasSubstr("camera_name: real\n"));
    EXPECT_THAT(text, HasSubstr("data: [458.65400000000005, 0, 367.215, 0, 0, 457.296, 248.375, 0, 0, 0, 1, 0]"));
    EXPECT_EQ(json_of({"camera", "calibration", "real", "-o", (folder / "").string()})["file"],
              (folder / "real.yaml").string());
    std::stringstream written;
    written << std::ifstream(folder / "real.yaml").rdbuf();
    EXPECT_EQ(written.str(), text);
    json_of({"camera", "create", "other"});
    const json other = json_of({"camera", "set", "other", "--calibration", (folder / "real.yaml").string()});
    EXPECT_EQ(other["intrinsics"], camera["intrinsics"]);
    EXPECT_EQ(other["size"], camera["size"]);
}

TEST_F(Cli, ACalibrationThatDoesNotFitIsRefusedWithItsFile) {
    TemporaryFolder folder;
    const std::string file = (folder / "k.yaml").string();
    std::ofstream(file)
        << "image_width: 640\nimage_height: 480\nK: {rows: 3, cols: 3, data: [500,0,320,0,500,240,0,0,1]}\n";
    const Outcome size = at_rig({"camera", "create", "a", "--calibration", file, "--size", "800x600"});
    EXPECT_EQ(size.code, 1);
    EXPECT_THAT(size.err, HasSubstr("k.yaml: is for pictures of 640x480, not 800x600"));
    const Outcome missing = at_rig({"camera", "set", "a", "--calibration", (folder / "none.yaml").string()});
    EXPECT_EQ(missing.code, 1);
    EXPECT_THAT(missing.err, HasSubstr("none.yaml: cannot be opened"));
    EXPECT_EQ(at_rig({"camera", "calibration", "a"}).code, 1);
}

TEST_F(Cli, CameraGetShowsEveryParameterInWords) {
    json_of({"camera", "create", "lobby", "--position", "1,2,3", "--zoom", "2.5", "--antialias", "ssaa3", "--set-ctrl",
             "contrast=1.25", "--mjpeg"});
    const std::string words = at_rig({"camera", "get", "lobby"}).out;
    for (const auto& entry : world::camera_fields()) {
        if (entry.field.by == Field::By::client) continue;
        EXPECT_THAT(words, HasSubstr(entry.field.label_text())) << entry.field.name;
    }
    EXPECT_THAT(words, AllOf(ContainsRegex("zoom +2.5\n"), ContainsRegex("antialias +ssaa3\n"),
                             ContainsRegex("controls contrast +1.25\n"), ContainsRegex("quality +the rig's\n"),
                             ContainsRegex("pose position +1,2,3 m\n"), ContainsRegex("code strip +no\n"),
                             ContainsRegex("outputs +\\{\"kind\":\"mjpeg\"\\}\n")));
}

TEST_F(Cli, OptionsOfTheTableAreReadByTheirType) {
    const json camera = json_of({"camera", "create", "a", "--near", "0.25", "--quality", "fast", "--code-strip"});
    EXPECT_EQ(camera["near"], 0.25);
    EXPECT_EQ(camera["code_strip"], true);
    const json after = json_of({"camera", "set", "a", "--quality", "none", "--no-code-strip"});
    EXPECT_EQ(after["quality"], nullptr);
    EXPECT_EQ(after["code_strip"], false);
    EXPECT_EQ(after["near"], 0.25);
    EXPECT_EQ(run({"camera", "set", "a", "--near", "close"}).code, 2);
    EXPECT_EQ(run({"camera", "set", "a", "--tilt-deg", "-100"}).code, 2);
    EXPECT_EQ(run({"camera", "set", "a", "--code-strip", "--no-code-strip"}).code, 2);
    const Outcome refused = at_rig({"camera", "set", "a", "--zoom", "11"});
    EXPECT_EQ(refused.code, 1);
    EXPECT_THAT(refused.err, HasSubstr("zoom: must be 1 to 10"));
}

TEST_F(Cli, AnActorIsSteered) {
    EXPECT_TRUE(json_of({"actor", "steer", "anna", "--velocity", "1.2,0,0", "--clip", "walk"}).contains("applied_ns"));
    EXPECT_TRUE(json_of({"actor", "steer", "anna", "--position", "1,2,0", "--seconds", "2"}).contains("applied_ns"));
    EXPECT_THAT(at_rig({"actor", "steer", "anna", "--velocity", "0,0,0"}).out, StartsWith("anna: steered"));
    EXPECT_EQ(run({"actor", "steer", "anna", "--velocity", "1,0,0", "--position", "1,2,0"}).code, 2);
    EXPECT_EQ(run({"actor", "steer", "anna", "--seconds", "2"}).code, 2);
    EXPECT_THAT(at_rig({"actor", "steer", "anna"}).err, HasSubstr("say how: --velocity X,Y,Z"));
}

/// A parameter that a method gets needs no edit of the command line.
TEST_F(Cli, CommandsOfActorsObjectsAndEventsTakeAllThatTheirMethodsTake) {
    const auto expect_options = [](std::vector<std::string> command, const std::vector<Field>& fields) {
        command.push_back("--help");
        const std::string help = run(command).out;
        for (const Field& field : fields)
            EXPECT_THAT(help, HasSubstr(field.name == "name" ? "NAME" : "--" + field.option_text())) << field.name;
        EXPECT_FALSE(fields.empty());
    };
    for (const char* method : {"actor.spawn", "actor.set", "object.spawn", "object.set", "event.add"}) {
        const std::string name = method;
        const auto dot = name.find('.');
        expect_options({name.substr(0, dot), name.substr(dot + 1)}, cli::params_of(method));
    }
    expect_options({"actor", "steer"}, cli::params_of("actor.steer").front().parts);
}

TEST_F(Cli, OptionsOfMethodsHaveTheJsonTypeOfTheirField) {
    const json guest = json_of({"actor", "spawn", "guest", "--model", "person_1", "--position", "1,-2,0.5", "--scale",
                                "2", "--class", "person", "--behaviour", R"({"type": "wander", "area": "hall"})"});
    EXPECT_EQ(guest["position"], json({1, -2, 0.5}));
    EXPECT_EQ(guest["scale"], 2);
    EXPECT_EQ(guest["class"], "person");
    EXPECT_EQ(guest["behaviour"], "wander");
    EXPECT_TRUE(json_of({"actor", "set", "guest", "--detach", "--play", "none", "--play-speed", "0.5"}).is_object());
    EXPECT_EQ(json_of({"object", "set", "--hidden", "table", "--scale", "0.5"})["hidden"], true);
    EXPECT_EQ(json_of({"object", "set", "table", "--shown"})["hidden"], false);
    EXPECT_EQ(json_of({"event", "add", "alarm", "--when", R"({"at_s": 3})", "--limit", "2"})["limit"], 2);
    const json fired = json_of({"event", "wait", "--timeout", "0"});
    ASSERT_FALSE(fired["events"].empty());
    const json none = json_of({"event", "wait", "--new", "--timeout", "0"});
    for (const json& event : none["events"]) EXPECT_GT(event["sequence"], fired["last"]);
    EXPECT_EQ(run({"event", "wait", "--new", "--since", "1"}).code, 2);
    EXPECT_EQ(run({"object", "set", "table", "--hidden", "--shown"}).code, 2);
    EXPECT_EQ(json_of({"object", "set", "table", "--no-hidden"})["hidden"], false);
    EXPECT_EQ(run({"actor", "set", "anna", "--detach", "perhaps"}).code, 2);
    EXPECT_EQ(run({"actor", "spawn", "guest"}).code, 2);
    const Outcome place = run({"actor", "set", "anna", "--position", "1,2"});
    EXPECT_EQ(place.code, 2);
    EXPECT_THAT(place.err, HasSubstr("--position: takes 3 numbers"));
    const Outcome text = run({"event", "add", "alarm", "--when", "{at"});
    EXPECT_EQ(text.code, 2);
    EXPECT_THAT(text.err, HasSubstr("--when"));
    const Outcome both = at_rig({"actor", "set", "anna", "--yaw-deg", "3", "--orientation", "0,0,0,1"});
    EXPECT_EQ(both.code, 1);
    EXPECT_THAT(both.err, HasSubstr("orientation"));
}

TEST_F(Cli, EveryCommandHasWordsForPeople) {
    EXPECT_THAT(at_rig({"camera", "create", "lobby"}).out, StartsWith("lobby: 640x480 at 25 frames/s"));
    EXPECT_THAT(at_rig({"camera", "list"}).out, AllOf(StartsWith("NAME"), HasSubstr("lobby")));
    EXPECT_THAT(at_rig({"camera", "get", "lobby"}).out, HasSubstr("field of view"));
    EXPECT_THAT(at_rig({"camera", "set", "lobby", "--fps", "10"}).out, HasSubstr("at 10 frames/s"));
    EXPECT_THAT(at_rig({"world", "status"}).out, HasSubstr("world time"));
    EXPECT_THAT(at_rig({"world", "pause"}).out, HasSubstr("paused"));
    EXPECT_THAT(at_rig({"world", "resume"}).out, Not(HasSubstr("paused")));
    EXPECT_THAT(at_rig({"world", "step", "0.5"}).out, HasSubstr("0.500 s"));
    EXPECT_THAT(at_rig({"world", "load", "scenes/minimal.json"}).out, HasSubstr("minimal"));
    EXPECT_THAT(at_rig({"stats"}).out, AllOf(HasSubstr("RENDERED"), HasSubstr("127.0.0.1:5"), HasSubstr("draw")));
    EXPECT_THAT(at_rig({"camera", "delete", "lobby"}).out, HasSubstr("deleted"));
    EXPECT_THAT(run({"methods"}).out, HasSubstr("camera.create {name, [place]"));
    EXPECT_THAT(run({"version"}).out, StartsWith("camrig "));
    EXPECT_THAT(run({"--help"}).out, HasSubstr("serve"));
}

TEST_F(Cli, EveryCommandHasJson) {
    json_of({"camera", "create", "lobby"});
    EXPECT_EQ(json_of({"camera", "get", "lobby"})["name"], "lobby");
    EXPECT_EQ(json_of({"world", "step", "--nanoseconds", "5"})["world_ns"], 5);
    EXPECT_EQ(json_of({"world", "step", "--seconds", "0.2"})["world_ns"], 200'000'005);
    EXPECT_TRUE(json_of({"world", "status"}).contains("scene"));
    EXPECT_TRUE(json_of({"world", "pause"})["paused"]);
    EXPECT_TRUE(json_of({"stats"}).contains("stages"));
    EXPECT_TRUE(json_of({"methods"})["methods"].is_array());
    EXPECT_TRUE(json_of({"version"}).contains("version"));
    EXPECT_TRUE(json_of({"camera", "delete", "lobby"}).contains("applied_ns"));
    EXPECT_EQ(json_of({"call", "world.step", R"({"nanoseconds":1})"})["world_ns"], 200'000'006);
}

TEST_F(Cli, SnapshotWritesTheFileAtOnce) {
    TemporaryFolder folder;
    json_of({"camera", "create", "lobby"});
    for (const char* name : {"a.png", "a.jpg", "A.JPEG"}) {
        const std::string file = (folder / name).string();
        EXPECT_EQ(json_of({"snapshot", "lobby", "-o", file})["file"], file);
        EXPECT_EQ(std::filesystem::file_size(file), 3u);
    }
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator((folder / "a.png").parent_path()), {}), 3);
    EXPECT_EQ(at_rig({"snapshot", "lobby", "-o", "a.bmp"}).code, 2);
    EXPECT_EQ(at_rig({"snapshot", "lobby"}).code, 2);
    EXPECT_EQ(at_rig({"snapshot", "lobby", "-o", "a.png", "--quality", "50"}).code, 2);
    EXPECT_EQ(at_rig({"snapshot", "hall", "-o", (folder / "b.png").string()}).code, 1);
    EXPECT_EQ(at_rig({"snapshot", "lobby", "-o", (folder / "no/such/folder.png").string()}).code, 1);
    EXPECT_FALSE(std::filesystem::exists(folder / "b.png"));
}

TEST_F(Cli, ErrorsAreOneLineAndExitOne) {
    for (const std::vector<std::string>& arguments : {std::vector<std::string>{"camera", "get", "hall"},
                                                      {"call", "no.such"},
                                                      {"world", "load", "none.json"},
                                                      {"camera", "create", "Bad Name"},
                                                      {"camera", "create", "a", "--size", "1x1"}}) {
        const Outcome done = at_rig(arguments);
        EXPECT_EQ(done.code, 1) << arguments.front();
        EXPECT_THAT(done.err, StartsWith("camrig: "));
        EXPECT_EQ(std::ranges::count(done.err, '\n'), 1) << done.err;
        EXPECT_EQ(done.out, "");
    }
    TemporaryFolder folder;
    const Outcome nobody = run({"camera", "list", "--control", (folder / "none").string()});
    EXPECT_EQ(nobody.code, 1);
    EXPECT_THAT(nobody.err, HasSubstr("camrig serve"));
}

TEST_F(Cli, WrongUsageIsOneLineAndExitTwo) {
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{},
          {"camera"},
          {"camera", "create"},
          {"nonsense"},
          {"camera", "create", "a", "--siez", "1x1"},
          {"camera", "create", "a", "--size", "640"},
          {"camera", "create", "a", "--position", "1,2"},
          {"camera", "create", "a", "--position", "1,2,3,"},
          {"camera", "create", "a", "--look-at", "1,2,3"},
          {"camera", "create", "a", "--position", "1,2,nan"},
          {"camera", "create", "--file", "a.json", "--fps", "10"},
          {"camera", "create", "--file", "a.json", "--place", "gate"},
          {"camera", "create", "a", "--position", "1,2,3", "--replace"},
          {"--control", "box:7000", "serve", "x"},
          {"--control", "box:7000", "exec", "--", "true"},
          {"camera", "create", "a", "--vfov-deg", "6", "--hfov-deg", "5"},
          {"camera", "create", "a", "--intrinsics", "1,2,3"},
          {"camera", "create", "a", "--calibration-camera", "cam0"},
          {"camera", "create", "a", "--calibration", "x", "--vfov-deg", "6"},
          {"camera", "set", "a", "--set-ctrl", "gain_db"},
          {"camera", "set", "a", "--set-ctrl", "=1"},
          {"camera", "set", "a", "--set-ctrl", "gain_db=much"},
          {"camera", "calibration"},
          {"camera", "calibration", "a", "--ros", "-o", "x"},
          {"camera", "set", "a", "--position", "x,y,z"},
          {"camera", "get"},
          {"world", "step"},
          {"world", "step", "soon"},
          {"world", "step", "1", "--nanoseconds", "1"},
          {"call", "world.status", "{"},
          {"call", "world.status", "[]"},
          {"call"},
          {"stats", "--watch", "0"},
          {"serve"},
          {"serve", "x", "--mode", "fast"},
          {"serve", "x", "--http", "65536"},
          {"serve", "x", "--tcp", "no"},
          {"serve", "x", "--seed", "-1"}}) {
        const Outcome done = at_rig(arguments);
        std::string shown;
        for (const auto& argument : arguments) shown += argument + " ";
        EXPECT_EQ(done.code, 2) << shown << done.err;
        EXPECT_EQ(std::ranges::count(done.err, '\n'), 1) << shown << done.err;
    }
}

TEST_F(Cli, AnOptionThatMayBeGivenTwiceTakesOneWordAtATime) {
    const json camera = json_of({"camera", "create", "--position", "1,2,3", "--ptz", "preset=dome", "gate"});
    EXPECT_EQ(camera["name"], "gate");
    const Outcome far = at_rig({"record", "--cameras", "a,b", "/proc/nowhere"});
    EXPECT_EQ(far.code, 1) << far.err;
    EXPECT_THAT(far.err, HasSubstr("no camera 'a'"));
}

TEST_F(Cli, AnOptionThatIsNoneIsNamedWithWhatItMayHaveMeant) {
    EXPECT_THAT(at_rig({"camera", "create", "a", "--vfov", "60"}).err,
                AllOf(HasSubstr("camera create: no option --vfov"), HasSubstr("did you mean --vfov-deg?")));
    EXPECT_THAT(at_rig({"camera", "create", "a", "--siez", "1x1"}).err,
                AllOf(HasSubstr("no option --siez"), HasSubstr("did you mean --size?")));
    EXPECT_THAT(at_rig({"camera", "create", "a", "--colour", "1x1"}).err,
                AllOf(HasSubstr("no option --colour"), Not(HasSubstr("did you mean"))));
    EXPECT_THAT(at_rig({"camrea", "list"}).err, HasSubstr("no command 'camrea'; did you mean camera?; there are "));
    EXPECT_THAT(at_rig({"exec", "v4l2-ctl", "-d", "/dev/video0"}).err,
                HasSubstr("no option -d of its own; the program and its options come after --"));
    EXPECT_THAT(at_rig({"camera", "get", "a", "b"}).err, HasSubstr("camera get: 'b' is one word more"));
}

TEST_F(Cli, AWrongValueIsShownWithWhatWouldBeRight) {
    EXPECT_THAT(at_rig({"world", "step", "--seconds", "abc"}).err,
                HasSubstr("--seconds: expected a number, got 'abc'"));
    EXPECT_THAT(at_rig({"serve", "x", "--http", "65536"}).err,
                HasSubstr("--http: must be a number from 0 to 65535, got '65536'"));
    EXPECT_THAT(at_rig({"camera", "create", "a", "--vfov-deg", "--size", "64x48"}).err,
                HasSubstr("--vfov-deg: expected a number, got '--size'"));
    EXPECT_THAT(run({"camera", "create", "a", "--vfov-deg"}).err, HasSubstr("--vfov-deg: its value is missing"));
}

TEST_F(Cli, ARateThatIsNoneIsNamedOnce) {
    const Outcome rate = at_rig({"camera", "create", "a", "--fps", "0"});
    EXPECT_THAT(rate.err, AllOf(HasSubstr("fps: '0"), Not(HasSubstr("fps: fps"))));
}

TEST(CliServe, OptionsAreThoseOfTheContract) {
    const Outcome done = run({"serve",          "scenes/hall.json",
                              "--control",      "/tmp/c.sock",
                              "--host",         "::1",
                              "--http",         "0",
                              "--rtsp",         "9",
                              "--rtsp-encoder", "openh264enc",
                              "--tcp",          "10",
                              "--onvif",        "11",
                              "--token-file",   "/t",
                              "--mode",         "lockstep",
                              "--overload",     "slow",
                              "--seed",         "18446744073709551615",
                              "--quality",      "beautiful",
                              "--device",       "cpu",
                              "--ready-fd",     "5"});
    ASSERT_EQ(done.code, 0) << done.err;
    const cli::ServeOptions& options = done.serve;
    EXPECT_EQ(options.scene, "scenes/hall.json");
    EXPECT_EQ(options.control, "/tmp/c.sock");
    EXPECT_EQ(options.rtsp_encoder, "openh264enc");
    EXPECT_EQ(options.host, "::1");
    EXPECT_EQ(options.http_port, 0);
    EXPECT_EQ(options.rtsp_port, 9);
    EXPECT_EQ(options.tcp_port, std::uint16_t{10});
    EXPECT_EQ(options.onvif_port, std::uint16_t{11});
    EXPECT_EQ(options.token_file, "/t");
    EXPECT_EQ(options.engine.mode, engine::RunMode::lockstep);
    EXPECT_EQ(options.engine.overload, engine::OverloadPolicy::slow);
    EXPECT_EQ(options.engine.seed, 18446744073709551615ULL);
    EXPECT_EQ(options.engine.quality, world::Quality::beautiful);
    EXPECT_EQ(options.engine.renderer.device, "cpu");
    EXPECT_EQ(options.ready_fd, 5);
}

TEST(CliServe, DefaultsAreThoseOfTheContract) {
    ::unsetenv("CAMRIG_CONTROL");
    ::unsetenv("XDG_RUNTIME_DIR");
    const cli::ServeOptions options = run({"serve", "a.glb"}).serve;
    EXPECT_EQ(options.control, "/tmp/camrig-" + std::to_string(::getuid()) + ".sock");
    EXPECT_EQ(options.host, "127.0.0.1");
    EXPECT_EQ(options.http_port, 8080);
    EXPECT_EQ(options.rtsp_port, 8554);
    EXPECT_EQ(options.tcp_port, std::nullopt);
    EXPECT_EQ(options.engine.mode, engine::RunMode::realtime);
    EXPECT_EQ(options.engine.seed, std::nullopt);
    EXPECT_EQ(options.ready_fd, -1);
    ::setenv("XDG_RUNTIME_DIR", "/run/user/7", 1);
    EXPECT_EQ(run({"serve", "a.glb"}).serve.control, "/run/user/7/camrig.sock");
    ::setenv("CAMRIG_CONTROL", "/elsewhere", 1);
    EXPECT_EQ(run({"serve", "a.glb"}).serve.control, "/elsewhere");
    ::unsetenv("CAMRIG_CONTROL");
    ::unsetenv("XDG_RUNTIME_DIR");
}

TEST(CliServe, WhoMayCommandOverTheNetworkIsChosenOnce) {
    EXPECT_FALSE(run({"serve", "x"}).serve.open_loopback || run({"serve", "x"}).serve.read_only);
    EXPECT_TRUE(run({"serve", "x", "--open-loopback"}).serve.open_loopback);
    EXPECT_TRUE(run({"serve", "x", "--read-only"}).serve.read_only);
    EXPECT_EQ(run({"serve", "x", "--read-only", "--open-loopback"}).code, 2);
}

TEST(CliPython, CommandsInPythonGetTheirArgumentsAsTheyAre) {
    const Outcome done = run({"--control", "/rig.sock", "--token-file", "/token", "--json", "ros2", "files", "out",
                              "--help", "--cameras", "a,b", "--", "snapshot"});
    EXPECT_EQ(done.code, 7);
    EXPECT_EQ(done.python.module, "camrig.ros2");
    EXPECT_THAT(done.python.arguments,
                testing::ElementsAre("--json", "files", "out", "--help", "--cameras", "a,b", "--", "snapshot"));
    EXPECT_THAT(done.python.environment, testing::ElementsAre(testing::Pair("CAMRIG_CONTROL", "/rig.sock"),
                                                              testing::Pair("CAMRIG_TOKEN_FILE", "/token")));
}

TEST(CliPython, ThePythonIsTheOneThatHasThePackage) {
    const TemporaryFolder folder;
    const auto program = [&](const std::string& name, int exit_code) {
        const std::filesystem::path file = folder / name;
        std::ofstream(file) << "#!/bin/sh\nexit " << exit_code << "\n";
        std::filesystem::permissions(file, std::filesystem::perms::owner_all);
        return file.string();
    };
    const std::string without = program("without", 1), with = program("with", 0), gone = folder / "gone";
    EXPECT_EQ(cli::find_python({gone, without, with}), with);
    const auto none = cli::find_python({without, gone});
    ASSERT_FALSE(none);
    EXPECT_THAT(none.error().message, AllOf(HasSubstr(without + ": has not both"), HasSubstr(gone + ": No such file"),
                                            HasSubstr("pip install"), HasSubstr("CAMRIG_PYTHON")));
}

TEST(CliPython, CamrigPythonIsTakenAndNoOther) {
    ::unsetenv("CAMRIG_PYTHON");
    EXPECT_THAT(cli::python_candidates("/src"), testing::ElementsAre("/src/.venv/bin/python", "python3"));
    EXPECT_THAT(cli::python_candidates({}), testing::ElementsAre("python3"));
    ::setenv("CAMRIG_PYTHON", "/opt/python", 1);
    EXPECT_THAT(cli::python_candidates("/src"), testing::ElementsAre("/opt/python"));
    ::unsetenv("CAMRIG_PYTHON");
}

TEST(CliPython, ACheckoutIsFoundFromTheProgramsPlaceInIt) {
    const TemporaryFolder folder;
    const std::filesystem::path& root = folder.path();
    std::filesystem::create_directories(root / "control" / "python");
    std::ofstream(root / "control" / "python" / "pyproject.toml");
    EXPECT_EQ(cli::checkout_of(root / "build" / "run" / "tools" / "camrig" / "camrig"), root);
    EXPECT_EQ(cli::checkout_of("/usr/bin/camrig"), std::filesystem::path());
    EXPECT_EQ(cli::checkout_of(""), std::filesystem::path());
}

}  // namespace
}  // namespace camrig::control::cli_test
