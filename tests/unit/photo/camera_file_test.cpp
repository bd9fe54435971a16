#include "core/photo/camera_file.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/photo/plate_view.h"

namespace camrig::photo {
namespace {

using testing::HasSubstr;

PlateView view_of(const KnownCamera& camera) {
    return {camera.intrinsics, *camera::LensMap::create(camera.lens), camera::world_from_optical_rotation(*camera.pose),
            camera.pose->position};
}

// x_camera = R x_world + t, y down, pixel centres at halves: 1 m to the right of and 2 m below the axis, 4 m ahead.
TEST(CameraFile, ColmapsCameraSeesWhatColmapSays) {
    const std::string cameras =
        "# Camera list\n1 OPENCV 800 600 500 510 400 300 -0.1 0.02 0.001 0.002\n2 PINHOLE 800 600 500 510 400 300\n";
    const std::string images =
        "# Image list\n1 1 0 0 0 0 0 0 1 a.jpg\n100 200 -1\n2 0.7071067811865476 0.7071067811865476 0 0 0 0.5 2 2 "
        "b.jpg\n\n";
    const auto camera = parse_colmap(cameras, images, "b.jpg");
    ASSERT_TRUE(camera) << camera.error().message;
    // The quaternion turns about x by 90 degrees: world y becomes z, world z becomes -y.
    const glm::dvec3 world(1, 2, -1.5);  // in the camera: (1, 1.5 + 0.5, 2 + 2)
    const auto px = view_of(*camera).project(world);
    ASSERT_TRUE(px);
    EXPECT_NEAR(px->x, 500 * 1.0 / 4.0 + 400 - 0.5, 1e-9);
    EXPECT_NEAR(px->y, 510 * 2.0 / 4.0 + 300 - 0.5, 1e-9);
    const auto other = parse_colmap(cameras, images, "a.jpg");
    ASSERT_TRUE(other);
    EXPECT_EQ(other->lens, (camera::Lens{camera::LensModel::plumb_bob, {-0.1, 0.02, 0.001, 0.002}}));
    EXPECT_THAT(parse_colmap(cameras, images, "").error().message, HasSubstr("name the image; it has a.jpg, b.jpg"));
    EXPECT_THAT(parse_colmap(cameras, images, "c.jpg").error().message, HasSubstr("no image c.jpg"));
    EXPECT_THAT(parse_colmap("1 FOV 800 600 1 2 3 4\n", "", "").error().message,
                HasSubstr("no model that is known here: FOV"));
    EXPECT_THAT(parse_colmap("1 PINHOLE 800 600 1\n", "", "").error().message, HasSubstr("too few numbers"));
    EXPECT_FALSE(parse_colmap("", "", ""));
    EXPECT_TRUE(parse_colmap("1 PINHOLE 800 600 500 500 400 300\r\n\r\n", "", ""));
    const std::string two = "1 PINHOLE 800 600 500 500 400 300\n2 PINHOLE 800 600 900 900 400 300\n";
    EXPECT_THAT(parse_colmap(two, "", "").error().message, HasSubstr("has 2 cameras; give images.txt too"));
    EXPECT_THAT(parse_colmap(two, "", "b.jpg").error().message, HasSubstr("b.jpg is named in images.txt"));
    EXPECT_THAT(parse_colmap("1 OPENCV 2000000000 2000000000 1e9 1e9 1e9 1e9 -0.01 0 0 0\n", "", "").error().message,
                HasSubstr("from 16x16 to 16384x16384"));
}

TEST(CameraFile, FspysCameraLooksAlongMinusZ) {
    const double hfov = 2.0 * std::atan(0.8);
    const auto text = [&](const std::string& rows) {
        return R"({"principalPoint": {"x": 0.1, "y": -0.05}, "imageWidth": 1000, "imageHeight": 600, "horizontalFieldOfView": )" +
               std::to_string(hfov) +
               R"(, "verticalFieldOfView": 0.8, "vanishingPoints": [], "cameraTransform": {"rows": )" + rows + "}}";
    };
    // Right is x, up is z, back is -y: looks along y from (1, -5, 2).
    const auto camera = parse_fspy(text("[[1,0,0,1],[0,0,-1,-5],[0,1,0,2],[0,0,0,1]]"));
    ASSERT_TRUE(camera) << camera.error().message;
    const auto px = view_of(*camera).project({2, 5, 3});  // 10 m ahead, 1 m to the right and up
    ASSERT_TRUE(px);
    EXPECT_NEAR(px->x, 499.5 + 50 + 625 * 0.1, 1e-3);
    EXPECT_NEAR(px->y, 299.5 + 25 - 625 * 0.1, 1e-3);
    EXPECT_THAT(parse_fspy(text("[[2,0,0,1],[0,0,-1,-5],[0,1,0,2],[0,0,0,1]]")).error().message,
                HasSubstr("is no rotation"));
    EXPECT_THAT(parse_fspy(text("[[1,0,0],[0,0,-1,-5]]")).error().message, HasSubstr("4 rows of 4 numbers"));
    EXPECT_FALSE(parse_fspy("{}"));
}

TEST(CameraFile, FspysAngleIsAcrossTheLongerSide) {
    const auto camera = parse_fspy(
        R"({"principalPoint": {"x": 0.1, "y": -0.05}, "imageWidth": 600, "imageHeight": 1000, "horizontalFieldOfView": )" +
        std::to_string(2.0 * std::atan(0.8)) +
        R"(, "cameraTransform": {"rows": [[1,0,0,1],[0,0,-1,-5],[0,1,0,2],[0,0,0,1]]}})");
    ASSERT_TRUE(camera) << camera.error().message;
    EXPECT_NEAR(camera->intrinsics.fx, 625, 1e-3);
    EXPECT_NEAR(camera->intrinsics.fy, 625, 1e-3);
    EXPECT_NEAR(camera->intrinsics.cx, 299.5 + 50, 1e-9);
    EXPECT_NEAR(camera->intrinsics.cy, 499.5 + 25, 1e-9);
}

TEST(CameraFile, IsToldByWhatIsInIt) {
    const std::string ros =
        "image_width: 800\nimage_height: 600\ncamera_name: gate\ncamera_matrix: {rows: 3, cols: 3, data: [500, 0, "
        "399.5, "
        "0, 510, 299.5, 0, 0, 1]}\ndistortion_model: plumb_bob\ndistortion_coefficients: {rows: 1, cols: 5, data: "
        "[-0.1, "
        "0, 0, 0, 0]}\n";
    const std::string cameras = "1 PINHOLE 800 600 500 510 400 300\n", images = "1 1 0 0 0 0 0 0 1 a.jpg\n\n";
    const std::string fspy =
        R"({"principalPoint": {"x": 0, "y": 0}, "imageWidth": 800, "imageHeight": 600, "horizontalFieldOfView": 1,
            "cameraTransform": {"rows": [[1,0,0,1],[0,0,-1,-5],[0,1,0,2],[0,0,0,1]]}})";
    const auto yaml = parse_camera_files({{"gate.yaml", ros}}, "", std::nullopt);
    ASSERT_TRUE(yaml) << yaml.error().message;
    EXPECT_EQ(yaml->intrinsics, (camera::Intrinsics{500, 510, 399.5, 299.5}));
    EXPECT_FALSE(yaml->pose);
    const auto colmap = parse_camera_files({{"cameras.txt", cameras}, {"images.txt", images}}, "", ImageSize{800, 600});
    ASSERT_TRUE(colmap) << colmap.error().message;
    EXPECT_EQ(colmap->intrinsics, (camera::Intrinsics{500, 510, 399.5, 299.5}));
    EXPECT_TRUE(colmap->pose);
    ASSERT_TRUE(parse_camera_files({{"a.json", fspy}}, "", std::nullopt));
    const auto wrong = [](const std::map<std::string, std::string>& texts, std::optional<ImageSize> size = {}) {
        return parse_camera_files(texts, "", size).error().message;
    };
    EXPECT_THAT(wrong({{"a.json", fspy}}, ImageSize{600, 800}),
                HasSubstr("a.json: is of a photo of 800x600, and this one is 600x800"));
    EXPECT_THAT(wrong({{"images.txt", images}}), HasSubstr("images.txt: belongs to a cameras.txt"));
    EXPECT_THAT(wrong({{"a.json", fspy}, {"b.json", fspy}}), HasSubstr("b.json: one file too many"));
    EXPECT_THAT(wrong({{"notes.txt", "hello"}}), HasSubstr("notes.txt: "));
    EXPECT_THAT(wrong({}), HasSubstr("no file is given"));
}

}  // namespace
}  // namespace camrig::photo
