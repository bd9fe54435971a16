#include "core/camera/calibration_file.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "core/camera/yaml_document.h"
#include "tests/temporary_folder.h"
#include "tests/unit/camera/calibration_samples.h"
#include "tests/unit/camera/random_lens.h"

namespace camrig::camera::calibration_file_test {
namespace {

std::string replaced(std::string text, std::string_view from, std::string_view to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

/// The message of a refusal; it must name the file.
std::string refusal(const std::string& text, const CalibrationQuery& query = {}) {
    const auto result = parse_calibration(text, "lab/left.yaml", query);
    if (result) return "accepted";
    EXPECT_EQ(result.error().message.find("lab/left.yaml: "), 0u) << result.error().message;
    return result.error().message;
}

/// A function and tables, not a macro: hundreds of string temporaries in one function take the sanitizers minutes to
/// compile.
void expect_refused(const std::string& text, std::string_view reason, const CalibrationQuery& query = {}) {
    const std::string message = refusal(text, query);
    EXPECT_NE(message.find(reason), std::string::npos) << message << "\nshould say: " << reason;
}

TEST(ReadCalibration, RosCameraInfo) {
    const auto c = parse_calibration(ros_sample, "x");
    ASSERT_TRUE(c) << c.error().message;
    EXPECT_EQ(c->camera_name, "head_camera");
    EXPECT_EQ(c->size, (ImageSize{640, 480}));
    EXPECT_EQ(c->intrinsics, (Intrinsics{438.783367, 437.302876, 305.593336, 243.738352}));
    EXPECT_EQ(c->lens, (Lens{LensModel::plumb_bob, {-0.361976, 0.110510, 0.001014, 0.000505, 0.0}}));
}

TEST(ReadCalibration, RosRationalAndEquidistant) {
    const std::string rational = replaced(replaced(ros_sample, "plumb_bob", "rational_polynomial"),
                                          "cols: 5\n  data: [-0.361976, 0.110510, 0.001014, 0.000505, 0.000000]",
                                          "cols: 8\n  data: [0.1, 0.2, 1e-3, -1e-3, 0.5, 0.3, 0.4, 0.6]");
    auto c = parse_calibration(rational, "x");
    ASSERT_TRUE(c) << c.error().message;
    EXPECT_EQ(c->lens, (Lens{LensModel::rational_polynomial, {0.1, 0.2, 1e-3, -1e-3, 0.5, 0.3, 0.4, 0.6}}));
    const std::string fisheye = replaced(replaced(ros_sample, "plumb_bob", "equidistant"),
                                         "cols: 5\n  data: [-0.361976, 0.110510, 0.001014, 0.000505, 0.000000]",
                                         "cols: 4\n  data: [+.1, -1e-2, 0, 1.E-3]");
    c = parse_calibration(fisheye, "x");
    ASSERT_TRUE(c) << c.error().message;
    EXPECT_EQ(c->lens, (Lens{LensModel::equidistant, {0.1, -0.01, 0, 0.001}}));
}

TEST(ReadCalibration, OpenCvYamlAndJsonSayTheSame) {
    const auto yaml = parse_calibration(opencv_yaml_sample, "x");
    const auto json = parse_calibration(opencv_json_sample, "x");
    ASSERT_TRUE(yaml) << yaml.error().message;
    ASSERT_TRUE(json) << json.error().message;
    EXPECT_EQ(*yaml, *json);
    EXPECT_EQ(yaml->size, (ImageSize{1920, 1080}));
    EXPECT_EQ(yaml->intrinsics, (Intrinsics{1050.25, 1048.5, 961.3, 537.8}));
    EXPECT_EQ(yaml->lens, (Lens{LensModel::plumb_bob, {-0.28, 0.08, 8e-4, -5e-4, -0.005}}));
}

TEST(ReadCalibration, OpenCvFisheyeAndStereoPairs) {
    const std::string four =
        replaced(replaced(replaced(opencv_yaml_sample, "rows: 5", "rows: 4"), ",\n       -0.0050000000000000001", ""),
                 "-0.28000000000000003", "0.01");
    auto c = parse_calibration(four, "x");
    ASSERT_TRUE(c) << c.error().message;
    EXPECT_EQ(c->lens.model, LensModel::plumb_bob);
    c = parse_calibration(four + "fisheye_model: 1\n", "x");
    ASSERT_TRUE(c) << c.error().message;
    EXPECT_EQ(c->lens, (Lens{LensModel::equidistant, {0.01, 0.08, 8e-4, -5e-4}}));

    const std::string pair =
        "%YAML:1.0\n---\nM1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 500., 0., 320., 0., 501., "
        "240., 0., 0., 1. ]\n"
        "D1: !!opencv-matrix\n   rows: 1\n   cols: 14\n   dt: d\n   data: [ .1, .2, 0., 0., .3, .4, .5, .6, 0., 0., "
        "0., 0., 0., 0. ]\n";
    c = parse_calibration(pair, "x", {"1", ImageSize{640, 480}});
    ASSERT_TRUE(c) << c.error().message;
    EXPECT_EQ(c->size, (ImageSize{640, 480}));
    EXPECT_EQ(c->lens, (Lens{LensModel::rational_polynomial, {.1, .2, 0, 0, .3, .4, .5, .6}}));
    expect_refused(pair, "which camera: 1 or 2");
    expect_refused(pair, "M2", {"2", ImageSize{640, 480}});
    expect_refused(pair, "image_width", {"1", {}});
    expect_refused(replaced(pair, ".6, 0.,", ".6, 0.01,"), "thin prism", {"1", ImageSize{640, 480}});
}

TEST(ReadCalibration, KalibrCamerasByNameAndTopic) {
    const auto left = parse_calibration(kalibr_sample, "x", {"cam0", {}});
    ASSERT_TRUE(left) << left.error().message;
    EXPECT_EQ(left->camera_name, "cam0");
    EXPECT_EQ(left->size, (ImageSize{752, 480}));
    EXPECT_EQ(left->intrinsics, (Intrinsics{458.654, 457.296, 367.215, 248.375}));
    EXPECT_EQ(left->lens, (Lens{LensModel::plumb_bob, {-0.2831, 0.0739, 0.00019, 1.76e-05}}));
    const auto right = parse_calibration(kalibr_sample, "x", {"/cam1/image_raw", {}});
    ASSERT_TRUE(right) << right.error().message;
    EXPECT_EQ(right->camera_name, "cam1");
    EXPECT_EQ(right->lens, (Lens{LensModel::equidistant, {0.0034, 0.0007, -0.0020, 0.0002}}));
    expect_refused(kalibr_sample, "several cameras; say which: cam0, cam1");
    expect_refused(kalibr_sample, "cam0, cam1", {"cam7", {}});
    expect_refused(replaced(kalibr_sample, "pinhole", "omni"), "cam0.camera_model", {"cam0", {}});
    expect_refused(replaced(kalibr_sample, "radtan", "fov"), "cam0.distortion_model", {"cam0", {}});
    expect_refused(replaced(kalibr_sample, "[752, 480]", "[752]"), "cam0.resolution", {"cam0", {}});
    expect_refused(replaced(kalibr_sample, "458.654, ", ""), "must hold 4 numbers, not 3", {"cam0", {}});
}

TEST(ReadCalibration, EveryMistakeIsRefusedWithFileKeyAndReason) {
    const std::string ros = ros_sample;
    const struct {
        const char* from;
        const char* to;
        const char* reason;
    } mistakes[] = {{"image_width: 640\n", "", "image_width: is missing"},
                    {"640", "640.5", "image_width: must be a whole number"},
                    {"640", "-640", "image_width"},
                    {"480", "99999", "image_height: must be a whole number from 1 to 8192"},
                    {"438.783367", ".nan", "camera_matrix.data[0]: must be a finite number"},
                    {"438.783367", "1e999", "camera_matrix.data[0]"},
                    {"438.783367", "438.7x", "camera_matrix.data[0]"},
                    {"438.783367", "-438.7", "fx"},
                    {"438.783367, 0.000000", "438.783367, 0.1", "skew"},
                    {"0.000000, 0.000000, 1.000000]", "0.000000, 0.000000, 2.0]", "[fx, 0, cx, 0, fy, cy, 0, 0, 1]"},
                    {"cols: 3", "cols: 4", "camera_matrix: is 3x4"},
                    {"cols: 3", "cols: 100000", "camera_matrix.cols"},
                    {"rows: 3", "rows: 1", "camera_matrix.data: must hold 3 numbers, not 9"},
                    {"rows: 3\n", "\n", "camera_matrix: has no rows"},
                    {"plumb_bob", "equidistant", "takes 4 coefficients, not 5"},
                    {"plumb_bob", "rational_polynomial", "rational_polynomial takes 8 numbers"},
                    {"plumb_bob", "ftheta", "distortion_model: 'ftheta' is none of pinhole, plumb_bob"},
                    {"-0.361976", "-1e6", "no rising branch"},
                    {"camera_matrix", "camera_matrox", "camera_matrix: is missing"}};
    for (const auto& [from, to, reason] : mistakes) expect_refused(replaced(ros, from, to), reason);
    expect_refused(ros + "image_width: 640\n", "image_width is given twice");
    expect_refused(ros + "binning_x: 2\n", "binning_x");
    expect_refused(ros + "roi: {x_offset: 10, y_offset: 0}\n", "roi.x_offset");
    expect_refused(ros, "640x480, not 1280x720", {"", ImageSize{1280, 720}});
    EXPECT_TRUE(parse_calibration(ros + "binning_x: 1\nroi: {x_offset: 0, y_offset: 0}\n", "x"));
}

TEST(ReadCalibration, WhatIsNoCalibrationIsRefused) {
    expect_refused("", "no calibration");
    expect_refused("hello", "no calibration");
    expect_refused("[1, 2, 3]", "no calibration");
    expect_refused("{}", "camera_matrix");
    expect_refused("a: [1, 2", "line");
    expect_refused("a: b: c: d", "line 1");
    expect_refused(std::string("a: \0b", 5), "zero bytes");
    expect_refused("<?xml version=\"1.0\"?>\n<opencv_storage/>", "XML");
    expect_refused(std::string(300 * 1024, 'a'), "256 KiB");
}

TEST(ReadCalibration, HostileDocumentsAreRefusedQuickly) {
    expect_refused(std::string(200000, '['), "brackets");
    expect_refused(std::string(200000, '{'), "brackets");
    std::string dashes;
    for (int i = 0; i < 60000; ++i) dashes += "- ";
    EXPECT_NE(refusal(dashes), "accepted");
    std::string deep;
    for (int i = 0; i < 300; ++i) deep += std::string(i, ' ') + "a:\n";
    EXPECT_NE(refusal(deep), "accepted");
    // The billion laughs: every level uses the one below nine times.
    std::string bomb = "a0: &a0 [x,x,x,x,x,x,x,x,x]\n";
    for (int i = 1; i < 9; ++i) {
        const std::string below = "*a" + std::to_string(i - 1);
        bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + below;
        for (int k = 0; k < 8; ++k) bomb += "," + below;
        bomb += "]\n";
    }
    expect_refused(bomb, "20000");
    expect_refused("a: &a [*a]", "16 deep");
    expect_refused("? [a, b]\n: c\n", "a key that is not plain text");
}

TEST(ReadCalibration, DamagedFilesAreAnErrorOrACalibrationNeverACrash) {
    const std::string samples[] = {ros_sample, opencv_yaml_sample, opencv_json_sample, kalibr_sample};
    Draw draw(99);
    int accepted = 0;
    for (int n = 0; n < 6000; ++n) {
        std::string text = samples[n % 4];
        const int edits = 1 + static_cast<int>(draw.uniform(0, 5));
        for (int e = 0; e < edits; ++e) {
            const auto at = static_cast<std::size_t>(draw.uniform(0, static_cast<double>(text.size())));
            const auto length = static_cast<std::size_t>(draw.uniform(0, 30));
            constexpr std::string_view nasty = "[]{}:,-&*!|>'\"%@`#?\n\t ~.0x9e";
            switch (static_cast<int>(draw.uniform(0, 4))) {
                case 0:
                    text[at] = static_cast<char>(static_cast<int>(draw.uniform(0, 256)));
                    break;
                case 1:
                    text[at] = nasty[static_cast<std::size_t>(draw.uniform(0, nasty.size()))];
                    break;
                case 2:
                    text.erase(at, length);
                    break;
                default:
                    text.insert(at, text.substr(at, length));
                    break;
            }
            if (text.empty()) text = "x";
        }
        accepted += parse_calibration(text, "x", {n % 8 < 4 ? "" : "cam0", ImageSize{640, 480}}).has_value();
    }
    EXPECT_LT(accepted, 6000);
}

TEST(ReadCalibrationFile, NamesTheFileThatIsNotThere) {
    const auto c = read_calibration_file("no/such/file.yaml");
    ASSERT_FALSE(c);
    EXPECT_EQ(c.error().kind, ErrorKind::not_found);
    EXPECT_EQ(c.error().message.find("no/such/file.yaml"), 0u);
    EXPECT_FALSE(read_calibration_file("tests"));  // a folder
}

TEST(ReadCalibrationFile, ReadsAFile) {
    const TemporaryFolder folder;
    const std::string path = folder / "camera.yaml";
    std::ofstream(path) << ros_sample;
    const auto c = read_calibration_file(path);
    ASSERT_TRUE(c) << c.error().message;
    EXPECT_EQ(*c, *parse_calibration(ros_sample, "x"));
}

TEST(WriteCameraInfo, IsWhatRosReads) {
    const Calibration c{
        "lobby", {640, 480}, {500.25, 499, 319.5, 239.5}, {LensModel::plumb_bob, {-0.1, 0.01, 1e-3, 2e-4, 0}}};
    const auto text = write_camera_info(c);
    ASSERT_TRUE(text) << text.error().message;
    EXPECT_EQ(*text, R"(image_width: 640
image_height: 480
camera_name: lobby
camera_matrix:
  rows: 3
  cols: 3
  data: [500.25, 0, 319.5, 0, 499, 239.5, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.1, 0.01, 0.001, 2.0e-04, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [500.25, 0, 319.5, 0, 0, 499, 239.5, 0, 0, 0, 1, 0]
)");
}

TEST(WriteCameraInfo, ComesBackExactlyForEveryModel) {
    for (std::uint64_t n = 0; n < 500; ++n) {
        Draw draw(n);
        const Calibration c{
            "cam_" + std::to_string(n),
            {1920, 1080},
            {draw.uniform(300, 2000), draw.uniform(300, 2000), draw.uniform(0, 1920), draw.uniform(0, 1080)},
            random_lens(n)};
        const auto text = write_camera_info(c);
        ASSERT_TRUE(text) << text.error().message;
        const auto back = parse_calibration(*text, "x");
        ASSERT_TRUE(back) << back.error().message;
        ASSERT_EQ(*back, c) << n;
    }
}

TEST(WriteCameraInfo, APinholeIsAPlumbBobOfZeros) {
    const auto text = write_camera_info({"c", {64, 48}, {50, 50, 31.5, 23.5}, {}});
    ASSERT_TRUE(text);
    const auto back = parse_calibration(*text, "x");
    ASSERT_TRUE(back);
    EXPECT_EQ(back->lens, (Lens{LensModel::plumb_bob, {}}));
}

TEST(WriteCameraInfo, RefusesNamesRosDoesNotTakeAndBadCameras) {
    const Calibration good{"lobby", {640, 480}, {500, 500, 319.5, 239.5}, {}};
    for (const char* name : {"", "a b", "a/b", "caf\xc3\xa9", "a: b"}) {
        Calibration c = good;
        c.camera_name = name;
        EXPECT_FALSE(write_camera_info(c)) << name;
    }
    Calibration bad = good;
    bad.intrinsics.fx = 0;
    EXPECT_FALSE(write_camera_info(bad));
    bad = good;
    bad.lens = {LensModel::plumb_bob, {-1e7}};
    EXPECT_FALSE(write_camera_info(bad));
}

TEST(ParseYaml, KeepsScalarsAsText) {
    const auto document = parse_yaml("a: 010\nb: yes\nc: ~\nd: {e: [1.0, x]}\n");
    ASSERT_TRUE(document);
    EXPECT_EQ(*document, (nlohmann::json{{"a", "010"}, {"b", "yes"}, {"c", nullptr}, {"d", {{"e", {"1.0", "x"}}}}}));
}

}  // namespace
}  // namespace camrig::camera::calibration_file_test
