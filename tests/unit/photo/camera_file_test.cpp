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

}  // namespace
}  // namespace camrig::photo
