
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/world/camera_json.h"

namespace camrig::world::camera_spec_test {
namespace {

using testing::HasSubstr;

Result<CameraSpec> create(const std::string& text) {
    const auto json = parse_json(text, 100000).value();
    JsonReader reader(json, "");
    CameraPatch patch = read_camera_patch(reader);
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    CameraSpec base;
    base.name = "cam";
    return patch_camera_spec(base, patch);
}

TEST(CameraSpec, EveryFieldOfTheContractIsTakenAndShownAgain) {
    const auto spec = create(R"({"size": [1920, 1080], "fps": "30000/1001", "hfov_deg": 90, "near": 0.1, "far": 50,
        "pose": {"position": [1, 2, 3], "pan_deg": 30, "tilt_deg": -10, "roll_deg": 5},
        "lens": {"model": "equidistant", "coefficients": [0.01, 0, 0, 0], "method": "cube", "filter": "bilinear"},
        "antialias": "msaa4", "quality": "fast", "code_strip": true,
        "outputs": [{"kind": "v4l2", "number": 3, "format": "YUYV"}, {"kind": "rtsp", "codec": "h264", "bitrate_kbps": 900,
                     "key_interval_s": 0.5, "preset": "fast", "profile": "high"},
                    {"kind": "mjpeg", "quality": 90}, {"kind": "device", "number": 0, "subsampling": "4:2:0"}]})");
    ASSERT_TRUE(spec) << spec.error().message;
    EXPECT_EQ(spec->rate, Rate::create(30000, 1001).value());
    EXPECT_NEAR(spec->intrinsics.fx, 960.0, 1e-9);
    EXPECT_NEAR(spec->intrinsics.cx, 959.5, 1e-12);
    const auto json = camera_to_json(*spec);
    EXPECT_EQ(json["size"], nlohmann::json({1920, 1080}));
    EXPECT_EQ(json["fps"], "30000/1001");
    EXPECT_NEAR(json["hfov_deg"].get<double>(), 90.0, 1e-9);
    EXPECT_NEAR(json["pose"]["pan_deg"].get<double>(), 30.0, 1e-9);
    EXPECT_NEAR(json["pose"]["roll_deg"].get<double>(), 5.0, 1e-9);
    EXPECT_EQ(json["outputs"][1], nlohmann::json::parse(R"({"kind": "rtsp", "codec": "h264", "bitrate_kbps": 900,
        "key_interval_s": 0.5, "preset": "fast", "profile": "high"})"));
    EXPECT_EQ(json["outputs"][3], nlohmann::json::parse(R"({"kind": "device", "number": 0, "subsampling": "4:2:0"})"));
    EXPECT_EQ(json["quality"], "fast");
    EXPECT_EQ(json["lens"], nlohmann::json::parse(R"({"model": "equidistant", "coefficients": [0.01, 0, 0, 0],
        "method": "cube", "filter": "bilinear"})"));
    EXPECT_EQ(json["antialias"], "msaa4");
}

TEST(CameraSpec, WhatCameraGetAnswersMakesTheSameCamera) {
    for (const char* text :
         {R"({})", R"({"size": [321, 240], "hfov_deg": 71.3, "quality": "fast", "outputs": [{"kind": "mjpeg"}],
                       "pose": {"position": [1e6, -2, 3], "pan_deg": 171.7, "tilt_deg": -33.3, "roll_deg": 5.5}})",
          R"({"intrinsics": {"fx": 500.1, "fy": 620.7, "cx": 300.3, "cy": 200.9},
              "pose": {"position": [1, 2, 3], "look_at": [1, 2, 0]}})",
          R"({"vfov_deg": 179.5, "pose": {"position": [0, 0, 0], "pan_deg": 10, "tilt_deg": 90, "roll_deg": 20}})"}) {
        const auto spec = create(text);
        ASSERT_TRUE(spec) << spec.error().message;
        nlohmann::json json = camera_to_json(*spec);
        json.erase("name");
        json.update({{"id", 7}, {"sequence", 3}, {"readers", 0}, {"applied_ns", 40}});
        const auto again = create(json.dump());
        ASSERT_TRUE(again) << json << '\n' << again.error().message;
        EXPECT_EQ(again->intrinsics, spec->intrinsics);
        EXPECT_EQ(again->quality, spec->quality);
        EXPECT_EQ(again->outputs, spec->outputs);
        EXPECT_EQ(again->pose.position, spec->pose.position);
        EXPECT_NEAR(std::abs(glm::dot(again->pose.orientation, spec->pose.orientation)), 1.0, 1e-15);
    }
}

TEST(CameraSpec, QualityNullIsTheRigsAgain) {
    const CameraSpec base = create(R"({"quality": "fast"})").value();
    const nlohmann::json change = {{"quality", nullptr}};
    JsonReader reader(change, "");
    const CameraPatch patch = read_camera_patch(reader);
    ASSERT_TRUE(reader.finish());
    EXPECT_EQ(patch_camera_spec(base, patch).value().quality, std::nullopt);
    EXPECT_EQ(patch_camera_spec(base, {}).value().quality, Quality::fast);
}

TEST(CameraSpec, ADescriptionIsTextOfAtMost200Characters) {
    EXPECT_EQ(camera_to_json(create("{}").value())["description"], "");
    const CameraSpec spec = create(R"({"description": "Gate 3, über der Tür"})").value();
    EXPECT_EQ(camera_to_json(spec)["description"], "Gate 3, über der Tür");
    EXPECT_EQ(patch_camera_spec(spec, {})->description, spec.description) << "what is not given stays";
    EXPECT_TRUE(create(R"({"description": ")" + std::string(200, 'x') + "\"}"));
    EXPECT_EQ(create(R"({"description": ")" + std::string(201, 'x') + "\"}").error().message,
              "description: must have at most 200 characters");
    EXPECT_FALSE(create(R"({"description": "two\nlines"})"));
}

TEST(CameraSpec, AGroupIsANameOfAtMost24Characters) {
    EXPECT_EQ(create(R"({"group": "stereo"})")->group, "stereo");
    EXPECT_EQ(create("{}")->group, "");
    EXPECT_FALSE(create(R"({"group": "a_name_of_more_than_24_ch"})"));
}

TEST(CameraSpec, ADifferentSizeKeepsTheFieldOfView) {
    const CameraSpec base = create(R"({"vfov_deg": 50})").value();
    CameraPatch patch;
    patch.size = ImageSize{1280, 960};
    const auto larger = patch_camera_spec(base, patch).value();
    EXPECT_NEAR(vfov_rad(larger.size, larger.intrinsics), glm::radians(50.0), 1e-12);
}

TEST(CameraSpec, ZoomScalesTheFocalLength) {
    const CameraSpec wide = create(R"({"vfov_deg": 60})").value();
    CameraPatch patch;
    patch.zoom = 2;
    const CameraSpec near = patch_camera_spec(wide, patch).value();
    EXPECT_DOUBLE_EQ(near.intrinsics.fy, 2 * wide.intrinsics.fy);
    EXPECT_DOUBLE_EQ(near.intrinsics.cy, wide.intrinsics.cy);
    patch = {};
    patch.size = ImageSize{1280, 960};
    EXPECT_DOUBLE_EQ(patch_camera_spec(near, patch)->intrinsics.fy, 4 * wide.intrinsics.fy);
    patch = {};
    patch.optics = VerticalFov{1.0};
    EXPECT_EQ(patch_camera_spec(near, patch)->zoom, 1.0);
}

// What camera.get answers has the zoom in its field of view; given back, it must not zoom twice.
TEST(CameraSpec, OpticsGivenWithAZoomAreThoseAtThatZoom) {
    const CameraSpec given = create(R"({"vfov_deg": 30, "zoom": 2})").value();
    EXPECT_NEAR(vfov_rad(given.size, given.intrinsics), glm::radians(30.0), 1e-12);
    CameraPatch patch;
    patch.zoom = 1;
    EXPECT_DOUBLE_EQ(patch_camera_spec(given, patch)->intrinsics.fy, given.intrinsics.fy / 2);
}

TEST(CameraSpec, AHeadTurnsWithoutMovingOrRolling) {
    const CameraSpec base =
        create(R"({"pose": {"position": [1, 2, 3], "pan_deg": 30, "tilt_deg": -10, "roll_deg": 5}})").value();
    CameraPatch patch;
    patch.pan_rad = glm::radians(-45.0);
    const CameraSpec turned = patch_camera_spec(base, patch).value();
    const camera::PanTiltRoll angles = camera::angles_of(turned.pose.orientation);
    EXPECT_NEAR(angles.pan, glm::radians(-45.0), 1e-12);
    EXPECT_NEAR(angles.tilt, glm::radians(-10.0), 1e-12);
    EXPECT_NEAR(angles.roll, glm::radians(5.0), 1e-12);
    EXPECT_EQ(turned.pose.position, base.pose.position);
}

TEST(CameraSpec, AGivenExposureOrTemperatureSwitchesItsAutomaticOff) {
    EXPECT_FALSE(create(R"({"controls": {"exposure_ev": 1}})")->controls.auto_exposure);
    EXPECT_TRUE(create(R"({"controls": {"exposure_ev": 1, "auto_exposure": true}})")->controls.auto_exposure);
    EXPECT_FALSE(create(R"({"controls": {"white_balance_k": 4000}})")->controls.auto_white_balance);
    const CameraSpec spec = create(R"({"controls": {"contrast": 1.5, "gain_db": 3}})").value();
    EXPECT_TRUE(spec.controls.auto_exposure && spec.controls.auto_white_balance);
    EXPECT_EQ(camera_to_json(spec)["controls"]["contrast"], 1.5);
}

TEST(CameraSpec, WrongFieldsAreErrorsThatSayWhere) {
    const std::vector<std::pair<const char*, const char*>> cases = {
        {R"({"size": [15, 16]})", "size: 15x16"},
        {R"({"size": [8193, 16]})", "size: 8193x16"},
        {R"({"size": [640]})", "size: expected [width, height]"},
        {R"({"size": [1e300, 5]})", "size: expected [width, height]"},
        {R"({"size": [99999999999, 5]})", "size: 1000000x5"},
        {R"({"fps": 0})", "fps"},
        {R"({"fps": "1/0"})", "fps"},
        {R"({"fps": 1001})", "fps"},
        {R"({"vfov_deg": 0})", "deg"},
        {R"({"vfov_deg": 180})", "deg"},
        {R"({"vfov_deg": 60, "hfov_deg": 60})", "only one of"},
        {R"({"vfov_deg": 60, "intrinsics": {"fx": 400, "fy": 400, "cx": 0, "cy": 0}})", "or size too"},
        {R"({"size": [64, 48], "vfov_deg": 60, "intrinsics": {"fx": 400, "fy": 400, "cx": 0, "cy": 0}})",
         "vfov_deg: is not that of the intrinsics"},
        {R"({"intrinsics": {"fx": 1, "fy": 1, "cx": 0}})", "intrinsics.cy: is missing"},
        {R"({"near": 0})", "near"},
        {R"({"near": 2, "far": 1})", "far"},
        {R"({"quality": "best"})", "quality: 'best' is none of fast, simple, beautiful"},
        {R"({"size": [64, 64], "code_strip": true})", "code_strip"},
        {R"({"lens": {"model": "zoom"}})", "lens.model"},
        {R"({"lens": {"model": "plumb_bob", "coefficients": [1, 2]}})", "lens.coefficients: expected an array of 5"},
        {R"({"lens": {"model": "plumb_bob", "coefficients": [-1e8, 0, 0, 0, 0]}})", "no rising branch"},
        {R"({"lens": {"model": "pinhole", "method": "fast"}})", "lens.method: 'fast' is none of auto, warp, cube"},
        {R"({"lens": {"model": "pinhole", "filter": "box"}})", "lens.filter: 'box' is none of auto, bilinear, bicubic"},
        {R"({"antialias": "msaa2"})", "antialias: 'msaa2' is none of none, coverage, msaa4, ssaa2, ssaa3, ssaa4, auto"},
        {R"({"outputs": [{"kind": "hdmi"}]})", "outputs[0].kind: 'hdmi'"},
        {R"({"outputs": [{"kind": "v4l2"}]})", "outputs[0].number: is missing"},
        {R"({"outputs": [{"kind": "v4l2", "number": 1, "format": "RGBX"}]})", "outputs[0].format"},
        {R"({"size": [161, 120], "outputs": [{"kind": "v4l2", "number": 1}]})",
         "outputs[0]: a v4l2 device needs an even width and height; the camera has 161x120"},
        {R"({"size": [160, 121], "outputs": [{"kind": "v4l2", "number": 1}]})", "needs an even width and height"},
        {R"({"outputs": [{"kind": "device", "number": 1, "subsampling": "4:4:4"}]})",
         "outputs[0].subsampling: '4:4:4' is none of 4:2:2, 4:2:0"},
        {R"({"outputs": [{"kind": "v4l2", "number": 1, "subsampling": "4:2:0"}]})", "outputs[0].subsampling: only"},
        {R"({"outputs": [{"kind": "mjpeg", "quality": 101}]})", "outputs[0].quality"},
        {R"({"outputs": [{"kind": "mjpeg"}, {"kind": "mjpeg"}]})", "outputs[1]: is the same output"},
        {R"({"outputs": [{"kind": "rtsp", "colour": 1}]})", "outputs[0].colour: unknown key"},
        {R"({"outputs": [{"kind": "rtsp", "size": 1}]})", "outputs[0].size: expected [width, height] in pixels"},
        {R"({"outputs": [{"kind": "rtsp", "bitrate_kbps": 15}]})", "outputs[0].bitrate_kbps: must be 16 to 200000"},
        {R"({"outputs": [{"kind": "rtsp", "key_interval_s": 0}]})", "outputs[0].key_interval_s"},
        {R"({"outputs": [{"kind": "rtsp", "preset": "best"}]})", "outputs[0].preset: 'best' is none of ultrafast"},
        {R"({"outputs": [{"kind": "rtsp", "profile": "extended"}]})", "outputs[0].profile"},
        {R"({"outputs": [{"kind": "rtsp", "quality": 50}]})", "outputs[0].quality: only mjpeg"},
        {R"({"outputs": [{"kind": "rtsp", "codec": "mjpeg", "preset": "fast"}]})", "outputs[0].preset: only"},
        {R"({"outputs": [{"kind": "mjpeg", "bitrate_kbps": 500}]})",
         "outputs[0].bitrate_kbps: unknown key; known here: kind, quality"},
        {R"({"pose": {"position": [1, 2]}})", "pose.position: expected an array of 3"},
        {R"({"pose": {"position": [1, 2, 3], "look_at": [1, 2, 3]}})", "pose"},
        {R"({"pose": {"position": [1, 2, 3], "look_at": [0, 0, 0], "pan_deg": 1}})", "only one of"},
        {R"({"pose": {"position": [1, 2, 3], "orientation": [0, 0, 0, 0]}})", "pose"},
        {R"({"pose": {"position": [1, 2, 3], "orientation": [0, 0, 0, 1], "tilt_deg": 0.001}})", "not the same"},
        {R"({"pose": {"position": [1e11, 2, 3]}})", "pose"},
        {R"({"zoom": 0.9})", "zoom: must be 1 to 10"},
        {R"({"controls": {"exposure_ev": 7}})", "controls.exposure_ev: must be -6 to 6"},
        {R"({"controls": {"gain_db": -1}})", "controls.gain_db: must be 0 to 24"},
        {R"({"controls": {"white_balance_k": 0}})", "controls.white_balance_k: must be 2800 to 10000"},
        {R"({"controls": {"sharpness": 1}})", "controls.sharpness: unknown key"},
        {R"({"controls": 1})", "controls"},
        {R"({"sensor": {"preset": "imx219"}, "antialias": "msaa4"})",
         "antialias: with a sensor it is auto, none or coverage"},
        {R"({"sensor": {"preset": "imx219"}, "lens": {"model": "pinhole", "method": "cube"}})", "lens: with a sensor"},
        {R"({"colour": 2})", "colour: unknown key"},
    };
    for (const auto& [text, expected] : cases) {
        const auto spec = create(text);
        ASSERT_FALSE(spec) << text;
        EXPECT_THAT(spec.error().message, HasSubstr(expected)) << text;
    }
}

}  // namespace
}  // namespace camrig::world::camera_spec_test
