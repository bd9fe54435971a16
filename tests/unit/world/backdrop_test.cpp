#include "core/world/backdrop/backdrop.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/camera/camera_model.h"
#include "core/world/backdrop/mask_pieces.h"
#include "core/world/backdrop/scale_picture.h"
#include "core/world/backdrop/triangulate.h"
#include "core/world/camera_json.h"
#include "core/world/read/check_walkable.h"
#include "core/world/scene.h"

namespace camrig::world::backdrop_test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

Image gray(ImageSize size, std::uint8_t code = 128) {
    return {.size = size, .rgba = std::vector<std::uint8_t>(static_cast<std::size_t>(size.pixels()) * 4, code)};
}

/// The camera that a scene file describes so, with a gray picture of 800x600 read for its backdrop.
Result<CameraSpec> camera(const std::string& backdrop, const std::string& more = "") {
    const auto json = parse_json(R"({"size": [800, 600], "vfov_deg": 50, "pose": {"position": [1, 2, 3], "pan_deg": 20,
        "tilt_deg": -12}, "backdrop": )" +
                                     backdrop + more + "}",
                                 100000)
                          .value();
    JsonReader reader(json, "");
    CameraPatch patch = read_camera_patch(reader);
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    auto files = std::make_shared<BackdropFiles>();
    files->picture = gray({800, 600});
    if (patch.backdrop && *patch.backdrop && (*patch.backdrop)->is_projected())
        files->projected = std::make_shared<const PicturePyramid>(make_pyramid(std::move(files->picture)));
    if (patch.backdrop && *patch.backdrop) (*patch.backdrop)->files = files;
    CameraSpec base;
    base.name = "gate";
    return patch_camera_spec(base, patch);
}
std::string proxies(const std::string& inside) {
    return R"({"file": "gate.png", "proxies": {)" + inside + "}}";
}

const std::string taken_from =
    R"("taken_from": {"position": [1, 2, 3], "pan_deg": 20, "tilt_deg": -12}, "intrinsics": {"fx": 640, "fy": 640,
       "cx": 399.5, "cy": 299.5},)";
std::string projected(const std::string& keys, const std::string& inside) {
    return R"({"kind": "projected", "file": "gate.png", )" + keys + R"("proxies": {)" + inside + "}}";
}

std::vector<glm::dvec3> places_of(const CameraSpec& spec) {
    std::vector<glm::dvec3> places;
    const Instance& own = spec.backdrop_here->proxies.at(0);
    for (const glm::vec3& p : own.info->model->meshes[0].primitives[0].positions)
        places.push_back(own.position + glm::dvec3(p.x, -p.z, p.y));
    return places;
}

glm::dvec2 pixel_of(const CameraSpec& spec, const glm::dvec3& place) {
    const auto model = camera::CameraModel::create(spec.size, spec.intrinsics, spec.lens).value();
    return model.project(glm::transpose(world_from_optical_rotation(spec.pose)) * (place - spec.pose.position)).value();
}

constexpr const char* lens_texts[] = {
    R"({"model": "pinhole"})", R"({"model": "plumb_bob", "coefficients": [-0.2, 0.05, 0.001, -0.001, 0]})",
    R"({"model": "rational_polynomial", "coefficients": [0.3, 0.02, 0.0005, -0.0004, 0.001, 0.6, 0.1, 0.01]})"};

TEST(Backdrop, GroundOutlinedInThePictureLiesUnderItsPixels) {
    for (const std::string lens : lens_texts) {
        const auto spec = camera(proxies(R"("ground": {"polygon_px": [[100, 560], [700, 580], [520, 330], [300, 340]],
            "z": 0.5})"),
                                 R"(, "lens": )" + lens);
        ASSERT_TRUE(spec) << spec.error().message;
        std::size_t corners = 0;
        for (const glm::dvec3& place : places_of(*spec)) {
            EXPECT_NEAR(place.z, 0.5, 1e-6);
            for (const glm::dvec2 wanted : {glm::dvec2(100, 560), {700, 580}, {520, 330}, {300, 340}})
                corners += glm::length(pixel_of(*spec, place) - wanted) < 1e-3;
        }
        EXPECT_EQ(corners, 4u) << lens;
    }
}

TEST(Backdrop, CutoutStandsUprightAtItsFootUnderItsOutline) {
    for (const std::string lens : lens_texts) {
        const auto spec = camera(
            proxies(
                R"("cutouts": [{"polygon_px": [[400, 450], [430, 450], [430, 120], [400, 100]], "foot_px": [410, 452]}])"),
            R"(, "lens": )" + lens);
        ASSERT_TRUE(spec) << spec.error().message;
        const auto model = camera::CameraModel::create(spec->size, spec->intrinsics, spec->lens).value();
        const glm::dvec3 ray = world_from_optical_rotation(spec->pose) * model.ray({410, 452}).value();
        const glm::dvec3 foot = spec->pose.position - ray * (spec->pose.position.z / ray.z);
        const glm::dvec2 ahead = glm::normalize(glm::dvec2(foot - spec->pose.position));
        // How far beside the nearest of the four sides it shows.
        const auto aside = [&](const glm::dvec3& place) {
            const glm::dvec2 pixel = pixel_of(*spec, place);
            return std::min({std::abs(pixel.x - 400), std::abs(pixel.x - 430), std::abs(pixel.y - 450),
                             std::abs(pixel.y - (100 + (pixel.x - 400) * 20 / 30))});
        };
        const std::vector<glm::dvec3> outline = places_of(*spec);
        for (std::size_t i = 0; i < outline.size(); ++i) {
            const glm::dvec3 &place = outline[i], &next = outline[(i + 1) % outline.size()];
            EXPECT_NEAR(glm::dot(glm::dvec2(place - foot), ahead), 0.0, 1e-5) << lens;
            EXPECT_LT(aside(place), 1e-3) << lens;
            // Straight in space, bent by the lens.
            EXPECT_LT(aside(0.5 * (place + next)), 0.1) << lens;
        }
    }
}

TEST(Backdrop, WhatIsWrongIsToldWithItsPlace) {
    struct Case {
        std::string backdrop, more, message;
    };
    const std::string ground = R"("ground": {"polygon_m": [[5, 2], [9, 2], [9, 6]]})";
    const Case cases[] = {
        {R"({"proxies": {}})", "", "backdrop.file: is missing"},
        {R"({"file": "gate.png"})", "", "backdrop.proxies: there are none"},
        {R"({"file": "gate.png", "kind": "movie"})", "", "backdrop.kind: "},
        {proxies(R"("ground": {"z": 1})"), "", "backdrop.proxies.ground: give one of polygon_m and polygon_px"},
        {proxies(R"("ground": {"polygon_m": [[5, 2], [9, 2], [9, 6]], "z": 4})"), "",
         "backdrop.proxies.ground.z: is not below the camera"},
        {proxies(R"("ground": {"polygon_m": [[-5, 2], [-9, 2], [-9, 6]]})"), "",
         "backdrop.proxies.ground.polygon_m: is behind the camera"},
        {proxies(R"("ground": {"polygon_px": [[100, 560], [700, 580], [520, 100]]})"), "",
         "backdrop.proxies.ground.polygon_px[2]: is over the horizon"},
        {proxies(R"("ground": {"polygon_m": [[5, 2], [9, 6], [9, 2], [5, 6]]})"), "",
         "backdrop.proxies.ground.polygon_m: the polygon crosses itself"},
        {proxies(
             R"("boxes": [{"position": [6, 4, 0], "size": [1, 1, 1]}, {"position": [-6, 0, 0], "size": [1, 1, 1]}])"),
         "", "backdrop.proxies.boxes[1]: is behind the camera"},
        {proxies(R"("boxes": [{"position": [6, 4, 0], "size": [1, 0, 1]}])"), "", "backdrop.proxies.boxes[0].size: "},
        {proxies(R"("boxes": [{"position": [6, 4, 0], "size": [1, 1, 1], "role": "shadow"}])"), "",
         "backdrop.proxies.boxes[0].role: "},
        {proxies(ground + R"(, "walkable": [{"polygon_m": [[5, 2], [9, 2], [9, 6]], "role": "catcher"}])"), "",
         "backdrop.proxies.walkable[0]"},
        {proxies(R"("cutouts": [{"polygon_px": [[1, 1], [9, 1], [9, 9]], "foot_px": [400, 60]}])"), "",
         "backdrop.proxies.cutouts[0].foot_px: is over the horizon"},
        {proxies(R"("cutouts": [{"polygon_px": [[1, 1], [9, 1]], "foot_px": [400, 460]}])"), "",
         "backdrop.proxies.cutouts[0].polygon_px: a polygon has at least 3 corners"},
        {R"({"file": "gate.png", "proxies": {)" + ground + R"(}, "ignore": [{"polygon_px": [[1, 1]]}]})", "",
         "backdrop.ignore[0].polygon_px: a polygon has at least 3 corners"},
        {proxies(ground), R"(, "ptz": {})", "ptz: a camera with a backdrop stands still"},
        {proxies(ground), R"(, "mount": {"actor": "car"})", "mount: a camera with a backdrop stands still"},
        {proxies(ground), R"(, "sensor": {})", "sensor: the picture of a backdrop went through a sensor already"},
        {proxies(ground), R"(, "antialias": "ssaa2")", "antialias: with a backdrop it is auto"},
        {proxies(ground), R"(, "lens": {"model": "pinhole", "method": "cube"})", "lens.method: "},
        {projected("", ground), "", "backdrop.taken_from: is missing"},
        {projected(R"("taken_from": {"position": [1, 2, 3]},)", ground), "", "backdrop.intrinsics: is missing"},
        {projected(taken_from + R"("ignore": [{"polygon_px": [[1, 1], [9, 1], [9, 9]]}],)", ground), "",
         "backdrop.ignore[0]: where it shows changes with the camera's pose"},
        {projected(taken_from + R"("lens": {"model": "plumb_bob"},)", ground), "", "backdrop.lens.coefficients: "},
        {projected(taken_from, R"("ground": {"polygon_px": [[100, 560], [700, 580], [520, 100]]})"), "",
         "backdrop.proxies.ground.polygon_px[2]: is over the horizon"},
        {projected(taken_from, ground), R"(, "antialias": "coverage")",
         "antialias: a projected picture is drawn without"},
        {projected(taken_from, ground), R"(, "sensor": {})", "sensor: "},
        {proxies(R"("depth": {"file": "d.png", "unit_m": 0})"), "", "backdrop.proxies.depth.unit_m: "},
        {proxies(R"("depth": {"file": "d.png", "measure": "far"})"), "", "backdrop.proxies.depth.measure: "},
    };
    for (const Case& one : cases) {
        const auto spec = camera(one.backdrop, one.more);
        ASSERT_FALSE(spec) << one.message;
        EXPECT_THAT(spec.error().message, StartsWith(one.message)) << one.backdrop;
    }
}

TEST(Backdrop, ShapesAreTakenByTheirRoles) {
    const auto spec = camera(proxies(R"("ground": {"polygon_m": [[5, 2], [9, 2], [9, 6]], "role": "catcher"},
        "boxes": [{"position": [6, 4, 0], "size": [1, 1, 1], "role": "holdout"},
                  {"position": [8, 4, 0], "size": [1, 1, 1]}])"));
    ASSERT_TRUE(spec) << spec.error().message;
    const auto mesh_of = [](const std::vector<Instance>& shapes) -> const Model& { return *shapes.at(0).info->model; };
    const Model &hiding = mesh_of(spec->backdrop_here->proxies), &catching = mesh_of(spec->backdrop_here->catchers);
    ASSERT_EQ(hiding.meshes[0].primitives.size(), 2u);
    for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
        EXPECT_EQ(hiding.meshes[0].primitives[i].positions.size(), 24u);
        EXPECT_EQ(hiding.materials[i].unlit, i == 1) << "a holdout has no light to lose";
    }
    ASSERT_EQ(catching.meshes[0].primitives.size(), 1u);
    EXPECT_EQ(catching.meshes[0].primitives[0].positions.size(), 3u);
    EXPECT_FALSE(catching.materials[0].unlit);
}

TEST(Backdrop, PictureHasTheSidesOfTheCamera) {
    auto spec = camera(proxies(R"("ground": {"polygon_m": [[5, 2], [9, 2], [9, 6]]})")).value();
    CameraPatch patch;
    patch.size = ImageSize{640, 360};
    const auto wrong = patch_camera_spec(spec, patch);
    ASSERT_FALSE(wrong);
    EXPECT_THAT(wrong.error().message, StartsWith("backdrop.file: a picture of 800x600 for a camera of 640x360"));
    patch.size = ImageSize{400, 300};
    const auto half = patch_camera_spec(spec, patch);
    ASSERT_TRUE(half) << half.error().message;
    EXPECT_EQ(half->backdrop_here->picture({})->size, (ImageSize{400, 300}));
    EXPECT_EQ(half->backdrop_here->picture({})->rgba[0], 128);
    EXPECT_EQ(half->backdrop_here->picture({})->rgba[3], 255);
}

TEST(Backdrop, IntrinsicsOfThePictureAreScaledWithIt) {
    const auto spec = camera(R"({"file": "gate.png", "intrinsics": {"fx": 700, "fy": 710, "cx": 410, "cy": 290},
        "proxies": {"ground": {"polygon_px": [[100, 560], [700, 580], [520, 330]]}}})");
    ASSERT_TRUE(spec) << spec.error().message;
    EXPECT_EQ(spec->intrinsics, (camera::Intrinsics{700, 710, 410, 290}));
    CameraPatch patch;
    patch.size = ImageSize{400, 300};
    const auto half = patch_camera_spec(*spec, patch).value();
    EXPECT_EQ(half.intrinsics, (camera::Intrinsics{350, 355, 204.75, 144.75}));
    const auto before = places_of(*spec), after = places_of(half);
    ASSERT_EQ(before.size(), after.size());
    for (std::size_t i = 0; i < before.size(); ++i) EXPECT_LT(glm::length(before[i] - after[i]), 1e-5);
}

TEST(Backdrop, WhatCameraGetAnswersIsTakenAgain) {
    const auto spec =
        camera(R"({"kind": "plate", "file": "gate.png", "proxies": {"ground": {"polygon_m": [[5, 2], [9, 2],
        [9, 6]], "z": 0.1}, "boxes": [{"position": [6, 4, 0], "size": [1, 2, 3], "yaw_deg": 30}], "cutouts":
        [{"polygon_px": [[400, 450], [430, 450], [430, 120]], "foot_px": [410, 452]}], "scene": "hidden"},
        "ignore": [{"polygon_px": [[1, 1], [9, 1], [9, 9]], "object_class": "vehicle"}]})");
    ASSERT_TRUE(spec) << spec.error().message;
    const nlohmann::json told = camera_to_json(*spec)["backdrop"];
    const auto again = camera(told.dump());
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(camera_to_json(*again)["backdrop"], told);
    EXPECT_EQ(again->backdrop->proxies, spec->backdrop->proxies);
    EXPECT_EQ(told["proxies"]["boxes"][0]["yaw_deg"], 30);
    EXPECT_EQ(camera_to_json(CameraSpec{})["backdrop"], nullptr);
}

TEST(Backdrop, ACommandThatChangesNothingOfItMakesItNotAnew) {
    const auto spec = camera(proxies(R"("ground": {"polygon_m": [[5, 2], [9, 2], [9, 6]]})")).value();
    CameraPatch patch;
    patch.change([](CameraSpec& target) { target.description = "north gate"; });
    EXPECT_EQ(patch_camera_spec(spec, patch)->backdrop_here, spec.backdrop_here);
    patch.pose = spec.pose;
    patch.pose->position.x += 0.1;
    EXPECT_NE(patch_camera_spec(spec, patch)->backdrop_here, spec.backdrop_here);
    patch.backdrop.emplace();
    EXPECT_EQ(patch_camera_spec(spec, patch)->backdrop_here, nullptr);
}

/// What a picture shows does not move with who looks at it.
TEST(Backdrop, AProjectedOneIsThatOfThePicturesCameraWhereverTheCameraIs) {
    const std::string ground = R"("ground": {"polygon_px": [[100, 560], [700, 580], [520, 330]]})";
    const auto plate = camera(R"({"file": "gate.png", "intrinsics": {"fx": 640, "fy": 640, "cx": 399.5, "cy": 299.5},
        "proxies": {)" + ground +
                              "}}")
                           .value();
    const auto spec = camera(projected(taken_from, ground), R"(, "zoom": 1.5)");
    ASSERT_TRUE(spec) << spec.error().message;
    EXPECT_NE(spec->intrinsics.fx, 640) << "the camera has its own";
    const auto places = places_of(*spec), of_plate = places_of(plate);
    ASSERT_EQ(places.size(), of_plate.size());
    for (std::size_t i = 0; i < places.size(); ++i) EXPECT_LT(glm::length(places[i] - of_plate[i]), 1e-9);
    CameraPatch patch;
    patch.pose = spec->pose;
    patch.pose->position.y += 0.3;
    patch.size = ImageSize{320, 200};
    patch.mount = Mount{.actor = "mast", .node = {}};
    const auto moved = patch_camera_spec(*spec, patch);
    ASSERT_TRUE(moved) << moved.error().message;
    EXPECT_EQ(moved->backdrop_here, spec->backdrop_here);
    nlohmann::json told = camera_to_json(*spec)["backdrop"];
    const auto again = camera(told.dump());
    ASSERT_TRUE(again) << again.error().message;
    nlohmann::json of_again = camera_to_json(*again)["backdrop"];
    // Angles are worked out of the orientation that was told.
    for (nlohmann::json* const of : {&told, &of_again}) {
        nlohmann::json& pose = (*of)["taken_from"];
        EXPECT_NEAR(pose["pan_deg"].get<double>(), 20, 1e-9);
        EXPECT_NEAR(pose["tilt_deg"].get<double>(), -12, 1e-9);
        pose.clear();
    }
    EXPECT_EQ(of_again, told);
    EXPECT_EQ(told["picture_size"], (nlohmann::json{800, 600}));
    EXPECT_EQ(told["lens"], nullptr);
    CameraPatch plain;
    plain.backdrop.emplace(plate.backdrop);
    (*plain.backdrop)->taken_from = spec->pose;
    EXPECT_THAT(load_backdrop(plain, "/nowhere").error().message,
                StartsWith("backdrop.taken_from: is that of a projected picture, and the kind is plate"));
}

TEST(Backdrop, FilesOfACommandAreAbsoluteAndThoseOfASceneBelowIt) {
    CameraPatch patch;
    patch.backdrop.emplace(BackdropSpec{});
    (*patch.backdrop)->file = "gate.png";
    EXPECT_THAT(load_backdrop(patch, "").error().message, StartsWith("backdrop.file: must be an absolute path"));
    EXPECT_THAT(load_backdrop(patch, "/nowhere").error().message, StartsWith("backdrop.file: /nowhere/gate.png: "));
    (*patch.backdrop)->file = "../gate.png";
    EXPECT_THAT(load_backdrop(patch, "/nowhere").error().message,
                StartsWith("backdrop.file: must be a path below the scene file's folder"));
}

TEST(ScaledPicture, IsTheMeanOfTheLightUnderEachPixel) {
    Image two = gray({2, 1}, 0);
    for (std::size_t c = 0; c < 3; ++c) two.rgba[4 + c] = 255;
    EXPECT_EQ(scaled_picture(two, {2, 1}).rgba, (std::vector<std::uint8_t>{0, 0, 0, 255, 255, 255, 255, 255}));
    EXPECT_EQ(scaled_picture(two, {1, 1}).rgba[0], 188);  // of linear 1/2
    // A pixel of three sees two thirds of one: linear 1/2 of the middle one.
    const Image three = scaled_picture(two, {3, 1});
    EXPECT_EQ(three.rgba[0], 0);
    EXPECT_EQ(three.rgba[4], 188);
    EXPECT_EQ(three.rgba[8], 255);
    for (int code = 0; code < 256; ++code)
        EXPECT_EQ(scaled_picture(gray({64, 48}, static_cast<std::uint8_t>(code)), {20, 15}).rgba[100], code);
}

TEST(Triangles, CoverAPolygonOnceInEitherOrder) {
    for (std::uint64_t n = 0; n < 200; ++n) {
        // Any radius about the middle, so that it does not cross itself.
        const std::size_t count = 3 + n % 40;
        std::vector<glm::dvec2> star;
        for (std::size_t i = 0; i < count; ++i) {
            const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
            star.push_back((0.2 + random_unit(3, n, i)) * glm::dvec2(std::cos(angle), std::sin(angle)));
        }
        if (n % 2 == 1) std::ranges::reverse(star);
        double area = 0.0, sum = 0.0;
        const auto twice = [&](const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
            return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        };
        for (std::size_t i = 1; i + 1 < count; ++i) area += twice(star[0], star[i], star[i + 1]);
        const auto triangles = triangles_of(star);
        ASSERT_TRUE(triangles) << n << ": " << triangles.error().message;
        for (const auto& [a, b, c] : *triangles) {
            EXPECT_GT(twice(star[a], star[b], star[c]), 0.0);
            sum += twice(star[a], star[b], star[c]);
        }
        EXPECT_NEAR(sum, std::abs(area), 1e-12) << n;
    }
    const std::vector<glm::dvec2> line{{0, 0}, {1, 1}, {2, 2}};
    EXPECT_THAT(triangles_of(line).error().message, HasSubstr("no area"));
}

/// Two pieces that touch, in the pictures of two cameras.
TEST(Backdrop, RoutesStayOnWhatIsWalkable) {
    Scene scene;
    const std::string ground = R"("ground": {"polygon_m": [[5, 2], [9, 2], [9, 6]]}, "walkable": )";
    scene.cameras.emplace_back();
    scene.cameras.push_back(camera(proxies(ground + R"([{"polygon_m": [[0, 0], [10, 0], [10, 4], [0, 4]]}])")).value());
    scene.cameras.push_back(
        camera(proxies(ground + R"([{"polygon_m": [[10, 0], [14, 0], [14, 10], [12, 2], [10, 2]]}])")).value());
    const auto message = [&](std::vector<glm::dvec3> points, bool closed = false) {
        scene.routes = {{"across", {.points = std::move(points), .closed = closed}}};
        const auto wrong = find_unwalkable(scene);
        return wrong ? wrong->message : std::string();
    };
    EXPECT_EQ(message({{1, 1, 0}, {9, 1, 0}, {13, 1, 0}}), "") << "over the side that they share";
    EXPECT_EQ(message({{0, 0, 0}, {10, 0, 0}, {10, 4, 0}, {0, 4, 0}}, true), "") << "along the border";
    EXPECT_EQ(
        message({{1, 1, 0}, {5, 4.1, 0}}),
        "routes.across.points[1]: is outside of what is walkable (cameras[1].backdrop.proxies.walkable); move it, "
        "or add ground there");
    EXPECT_THAT(message({{1, 1, 0}, {9, 3.5, 0}, {13.5, 7, 0}}),
                StartsWith("routes.across.points[1]: the way to the next point leaves what is walkable"));
    EXPECT_EQ(message({{13.5, 7, 0}, {13.5, 1, 0}, {1, 1, 0}}), "");
    EXPECT_THAT(message({{13.5, 7, 0}, {13.5, 1, 0}, {9, 3.9, 0}}, true),
                StartsWith("routes.across.points[1]: the way to the next point"));
    EXPECT_THAT(message({{13.5, 7, 0}, {13.5, 1, 0}, {9, 1, 0}}, true),
                StartsWith("routes.across.points[2]: the way to the next point"))
        << "a closed one comes back";
    scene.routes.clear();
    scene.areas["yard"].points = {{1, 1}, {13.5, 1}, {13.5, 7}};
    EXPECT_THAT(find_unwalkable(scene).value().message, StartsWith("areas.yard.points[2]: the way to the next point"));
    scene.cameras.resize(1);
    EXPECT_FALSE(find_unwalkable(scene)) << "nobody said anything";
    const auto far = camera(proxies(ground + R"([{"polygon_px": [[100, 560], [700, 580], [520, 20]]}])"));
    ASSERT_FALSE(far);
    EXPECT_THAT(far.error().message,
                StartsWith("backdrop.proxies.walkable[0].polygon_px[2]: is over the horizon of the ground"));
}

TEST(Backdrop, NobodyIsPutOutsideOfWhatIsWalkable) {
    Scene scene;
    EXPECT_FALSE(why_unwalkable(scene, {100, 100, 0})) << "nobody said anything";
    const std::string ground = R"("ground": {"polygon_m": [[5, 2], [9, 2], [9, 6]]}, "walkable": )";
    scene.cameras.emplace_back();
    scene.cameras.push_back(camera(proxies(ground + R"([{"polygon_m": [[0, 0], [10, 0], [10, 4], [0, 4]]}])")).value());
    EXPECT_FALSE(why_unwalkable(scene, {3, 3, 0}));
    EXPECT_FALSE(why_unwalkable(scene, {10, 4, 0})) << "on the border";
    EXPECT_EQ(
        why_unwalkable(scene, {3, 4.1, 0}),
        "is outside of what is walkable (cameras[1].backdrop.proxies.walkable); give a place on it, or add ground "
        "there");
}

TEST(MaskPieces, CoverWhatIsMarkedOnceInSmallRectangles) {
    for (const bool by_alpha : {true, false}) {
        Image mask = gray({131, 67}, by_alpha ? 255 : 0);
        std::vector<bool> marks;
        for (std::size_t i = 0; i < mask.rgba.size() / 4; ++i) {
            // Large areas, and single pixels in them and beside.
            marks.push_back((i / 40 % 2 == 0) != (random_unit(3, 1, i) < 0.1));
            const auto code = static_cast<std::uint8_t>(marks.back() ? 128 : 127);
            std::fill_n(&mask.rgba[4 * i], 3, by_alpha ? 9 : code);
            mask.rgba[4 * i + 3] = by_alpha ? code : 255;
        }
        std::vector<int> covered(marks.size());
        const auto pieces = mask_pieces(mask);
        ASSERT_TRUE(pieces) << pieces.error().message;
        for (const PixelRect& piece : *pieces) {
            EXPECT_TRUE(piece.width() >= 1 && piece.width() <= 16 && piece.height() >= 1 && piece.height() <= 16);
            for (int y = piece.y0; y < piece.y1; ++y)
                for (int x = piece.x0; x < piece.x1; ++x) ++covered[static_cast<std::size_t>(y * 131 + x)];
        }
        for (std::size_t i = 0; i < marks.size(); ++i) ASSERT_EQ(covered[i], marks[i] ? 1 : 0) << i;
    }
}

TEST(MaskPieces, MasksOfNothingAndOfTooMuchAreRefused) {
    EXPECT_THAT(*mask_pieces(gray({64, 64}, 255)), testing::SizeIs(16));
    Image dark = gray({64, 64}, 0);
    EXPECT_THAT(mask_pieces(dark).error().message, HasSubstr("marks nothing"));
    Image board = gray({400, 400}, 255);
    for (std::size_t i = 0; i < board.rgba.size() / 4; ++i)
        board.rgba[4 * i + 3] = (i % 400 + i / 400) % 2 == 0 ? 255 : 0;
    EXPECT_THAT(mask_pieces(board).error().message, HasSubstr("is too ragged"));
}

}  // namespace
}  // namespace camrig::world::backdrop_test
