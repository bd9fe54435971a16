#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include <gtest/gtest.h>

#include "tests/render/support/test_rig.h"

namespace camrig::render {
namespace {

/// World point that the test camera (looking along +x) sees at pixel (u, v), `depth` metres away.
glm::vec3 point_at(const camera::Intrinsics& k, double u, double v, double depth) {
    return glm::vec3(glm::dvec3(depth, -(u - k.cx) / k.fx * depth, -(v - k.cy) / k.fy * depth));
}

// An edge that leans by a whole number of pixels over the picture crosses the pixel grid at equally spaced phases, so
// the mean over all rows of "pixels left of the edge" is the mean edge position + 1/2, within 1 / (2 * rows): 0.001 px.
TEST(Geometry, AnEdgeLandsWithinAHundredthOfAPixel) {
    const ImageSize size{640, 480};
    const camera::Intrinsics intrinsics{.fx = 611.3, .fy = 587.9, .cx = 301.7, .cy = 255.2};
    for (const double place : {77.13, 320.5, 571.846}) {
        for (const double depth : {0.3, 4.0, 900.0}) {
            constexpr double lean = 7.0;
            const auto edge_at = [&](double v) { return place + lean * (v - 239.5) / size.height; };
            TestWorld world;
            // Corners at different depths: perspective must not bend the edge.
            world.objects = {instance_of(model_of(
                triangles({point_at(intrinsics, -200, -100, depth), point_at(intrinsics, -200, 580, 1.5 * depth),
                           point_at(intrinsics, edge_at(-100), -100, depth),
                           point_at(intrinsics, edge_at(-100), -100, depth),
                           point_at(intrinsics, -200, 580, 1.5 * depth),
                           point_at(intrinsics, edge_at(580), 580, 2.0 * depth)}),
                [] {
                    world::Material white = colored(glm::vec3(1.0f), true);
                    white.double_sided = true;
                    return white;
                }()))};
            const Picture picture = draw(world, {.size = size, .intrinsics = intrinsics});
            double covered = 0;
            for (int y = 0; y < size.height; ++y) {
                for (int x = 0; x < size.width; ++x) covered += picture.red(x, y) > 127;
            }
            EXPECT_NEAR(covered / size.height - 0.5, place, 0.01) << "depth " << depth;
        }
    }
}

TEST(Geometry, AHorizontalEdgeLandsWithinAHundredthOfAPixel) {
    const ImageSize size{640, 480};
    const camera::Intrinsics intrinsics{.fx = 611.3, .fy = 587.9, .cx = 301.7, .cy = 255.2};
    for (const double place : {33.27, 401.91}) {
        const auto edge_at = [&](double u) { return place + 9.0 * (u - 319.5) / size.width; };
        TestWorld world;
        world::Material white = colored(glm::vec3(1.0f), true);
        white.double_sided = true;
        world.objects = {instance_of(model_of(
            triangles({point_at(intrinsics, -200, -300, 3), point_at(intrinsics, 900, -300, 3),
                       point_at(intrinsics, -200, edge_at(-200), 5), point_at(intrinsics, -200, edge_at(-200), 5),
                       point_at(intrinsics, 900, -300, 3), point_at(intrinsics, 900, edge_at(900), 4)}),
            white))};
        const Picture picture = draw(world, {.size = size, .intrinsics = intrinsics});
        double covered = 0;
        for (int y = 0; y < size.height; ++y) {
            for (int x = 0; x < size.width; ++x) covered += picture.red(x, y) > 127;
        }
        EXPECT_NEAR(covered / size.width - 0.5, place, 0.01);
    }
}

TestWorld cluttered(glm::dvec3 offset) {
    TestWorld world;
    world.lights = {light_of(world::LightType::point, 4.0f, offset + glm::dvec3(2, 1, 2))};
    for (std::uint32_t i = 0; i < 20; ++i) {
        world::Instance box_i =
            instance_of(model_of(box({0.4f, 0.3f, 0.5f}), colored({0.1f + 0.04f * i, 0.5f, 0.3f})),
                        offset + glm::dvec3(4.0 + 0.25 * (i % 7), 0.5 * i - 5.0, 0.125 * (i % 5)), i + 1);
        box_i.orientation = glm::angleAxis(0.3 * i, glm::normalize(glm::dvec3(1, i, 2)));
        world.objects.push_back(box_i);
    }
    return world;
}

TEST(Geometry, TheSameSceneFarFromTheOriginGivesTheSameBytes) {
    const Picture here = draw(cluttered(glm::dvec3(0.0)), {.size = {320, 240}, .focal_px = 200});
    for (const double offset : {1e6, -1e9}) {
        const Picture there =
            draw(cluttered(glm::dvec3(offset)), {.eye = glm::dvec3(offset), .size = {320, 240}, .focal_px = 200});
        EXPECT_TRUE(std::ranges::equal(here.frame->bytes(), there.frame->bytes())) << offset;
    }
}

TEST(Geometry, BackFacesAreHiddenUnlessDoubleSided) {
    const world::Primitive away = rectangle({2, 0, 0}, {0, 4, 0}, {0, 0, 4});
    world::Material material = colored(glm::vec3(1.0f));
    TestWorld world;
    world.objects = {instance_of(model_of(away, material))};
    EXPECT_EQ(draw(world, {}).red(32, 24), 0);
    material.double_sided = true;
    world.objects = {instance_of(model_of(away, material))};
    EXPECT_EQ(draw(world, {}).red(32, 24), 255);
}

// glTF 2.0, 3.7.4: a negative determinant turns the winding round, so the front stays the front.
TEST(Geometry, AMirroredNodeKeepsItsFrontAndItsNormals) {
    auto model = model_of(rectangle({2, 0, 0}, {0, -4, 0}, {0, 0, 4}), colored(glm::vec3(1.0f)));
    glm::dmat4 mirror(1.0);
    mirror[1][1] = -1.0;
    model->nodes[0].matrix = model->nodes[0].matrix * mirror;
    TestWorld world;
    world.environment.ambient_sky = world.environment.ambient_ground = glm::vec3(0.0f);
    world.lights = {light_of(world::LightType::directional, 0.5f, {}, {1, 0, 0})};
    world.objects = {instance_of(model)};
    EXPECT_NEAR(draw(world, {}).red(32, 24), srgb_code(0.5), 1);
}

/// The mirror is in what moves the vertices, not in what places them.
TEST(Geometry, AMirroredNodeWhoseMeshIsMorphedKeepsThemToo) {
    auto model = model_of(rectangle({2, 0, 0}, {0, -4, 0}, {0, 0, 4}), colored(glm::vec3(1.0f)));
    model->nodes[0].matrix[1] *= -1.0;
    world::Primitive& wall = model->meshes[0].primitives[0];
    wall.targets.push_back({.positions = std::vector<glm::vec3>(wall.positions.size()), .normals = {}});
    model->meshes[0].weights = {0.0};
    TestWorld world;
    world.environment.ambient_sky = world.environment.ambient_ground = glm::vec3(0.0f);
    world.lights = {light_of(world::LightType::directional, 0.5f, {}, {1, 0, 0})};
    world.objects = {instance_of(model)};
    EXPECT_NEAR(draw(world, {}).red(32, 24), srgb_code(0.5), 1);
    world.movers = std::exchange(world.objects, {});
    EXPECT_NEAR(draw(world, {}).red(32, 24), srgb_code(0.5), 1);
}

TEST(Geometry, NearPlaneCutsAndWhatIsBehindTheCameraIsGone) {
    TestWorld world;
    world.objects = {instance_of(model_of(box(glm::vec3(1.0f)), colored({1, 0, 0}, true)), {-3, 0, 0})};
    EXPECT_EQ(draw(world, {}).red(32, 24), 0);
    // A wall through the camera, seen edge-on and crossing the near plane, must not smear.
    world::Material both = colored({0, 1, 0}, true);
    both.double_sided = true;
    world.objects = {instance_of(model_of(rectangle({0, 0, -1}, {50, 0, 0}, {0, 50, 0}), both))};
    const Picture floor = draw(world, {});
    EXPECT_EQ(floor.at(32, 10)[1], 0);  // above the horizon
    EXPECT_EQ(floor.at(32, 47)[1], 255);
}

TEST(Geometry, PointsAndLinesAreDrawnWhereTheyAre) {
    const TestCamera camera{.size = {65, 49}};
    const camera::Intrinsics k{64, 64, 32, 24};
    world::Primitive dots;
    dots.topology = world::Topology::points;
    dots.positions = {point_at(k, 10, 12, 5), point_at(k, 50, 40, 9)};
    dots.indices = {0, 1};
    world::Primitive line;
    line.topology = world::Topology::lines;
    line.positions = {point_at(k, 5, 30, 5), point_at(k, 60, 30, 5)};
    line.indices = {0, 1};
    TestWorld world;
    world.objects = {instance_of(model_of(dots, colored({1, 1, 1})), {}, 1),
                     instance_of(model_of(line, colored({1, 1, 1})), {}, 2)};
    const Picture picture = draw(world, camera);
    EXPECT_EQ(picture.red(10, 12), 255);
    EXPECT_EQ(picture.red(50, 40), 255);
    EXPECT_EQ(picture.red(30, 30), 255);
    EXPECT_EQ(picture.red(30, 33), 0);
}

/// A strip of two squares; the upper two corners hang on joint 1, which is moved by the node's translation.
std::shared_ptr<world::Model> skinned_strip(glm::dvec3 joint_moved_by) {
    auto model = model_of(rectangle({2, 0, 0}, {0, -0.25f, 0}, {0, 0, 0.25f}), colored(glm::vec3(1.0f), true));
    world::Primitive& p = model->meshes[0].primitives[0];
    p.joints = {{0, 0, 0, 0}, {0, 0, 0, 0}, {1, 0, 0, 0}, {1, 0, 0, 0}};
    p.weights.assign(4, glm::vec4(1, 0, 0, 0));
    const glm::dmat4 turn = model->nodes[0].matrix;
    model->nodes[0].skin = 0;
    world::Node joint;
    joint.has_matrix = true;
    joint.matrix = turn;
    model->nodes.push_back(joint);
    joint.matrix[3] = glm::dvec4(glm::dmat3(turn) * joint_moved_by, 1.0);
    model->nodes.push_back(joint);
    model->order = {0, 1, 2};
    model->skins.push_back({.name = "skin", .joints = {1, 2}, .inverse_bind = {glm::dmat4(1.0), glm::dmat4(1.0)}});
    return model;
}

TEST(Geometry, SkinnedVerticesFollowTheirJointsAndAreNotCulledByTheirRestPose) {
    const TestCamera camera{.size = {64, 64}, .focal_px = 64};
    TestWorld world;
    world.movers = {instance_of(skinned_strip({0, 0, 0}))};
    const Picture rest = draw(world, camera);
    EXPECT_EQ(rest.red(32, 30), 255);
    EXPECT_EQ(rest.red(32, 10), 0);
    world.movers = {instance_of(skinned_strip({0, 0, 0.5}))};
    EXPECT_EQ(draw(world, camera).red(32, 10), 255);
    // Rest pose out of sight, posed into it.
    TestWorld moved;
    moved.movers = {instance_of(skinned_strip({0, 0, 3}), {0, 0, -3})};
    EXPECT_EQ(draw(moved, camera).red(32, 32), 255);
}

TEST(Geometry, ASkinsMirrorTurnsNothingInsideOut) {
    const TestCamera camera{.size = {64, 64}, .focal_px = 64};
    auto model = skinned_strip({0, 0, 0});
    for (const std::size_t joint : {1, 2}) model->nodes[joint].matrix[1] *= -1.0;
    TestWorld world;
    world.movers = {instance_of(model)};
    EXPECT_EQ(draw(world, camera).red(32, 30), 255);
}

/// A hat, say: it stands where its node puts it.
TEST(Geometry, APartOfASkinnedMeshWithoutJointsIsSeenWhereverItIs) {
    const TestCamera camera{.size = {64, 64}, .focal_px = 64};
    auto model = skinned_strip({0, 0, 0});
    world::Primitive part = rectangle({2, 0, 0}, {0, -0.25f, 0}, {0, 0, 0.25f});
    for (glm::vec3& p : part.positions) p.z += 3.0f;
    part.material = 0;
    part.bounds = {part.positions.front(), part.positions.front()};
    model->meshes[0].primitives = {part};
    TestWorld world;
    world.movers = {instance_of(model, {0, 0, -3})};
    EXPECT_EQ(draw(world, camera).red(32, 30), 255);
}

TEST(Geometry, AMeshWithASkinAndWithoutIsWhereEachNodeHasIt) {
    // The node without a skin is a metre to the left, where the strip stands as it was modelled.
    const TestCamera camera{.size = {64, 64}, .focal_px = 40};
    auto model = skinned_strip({0, 0, 0.5});
    world::Node rigid = model->nodes[0];
    rigid.skin = -1;
    const glm::dvec3 left = glm::dmat3(rigid.matrix) * glm::dvec3(0, 1, 0);
    for (int i = 0; i < 3; ++i) rigid.matrix[3][i] += left[i];
    model->nodes.push_back(rigid);
    model->order.push_back(3);
    for (const bool moves : {false, true}) {
        TestWorld world;
        std::vector<world::Instance>& place = moves ? world.movers : world.objects;
        place.push_back(instance_of(model));
        const Picture picture = draw(world, camera);
        EXPECT_EQ(picture.red(32, 20), 255) << "the skinned one reaches up";
        EXPECT_EQ(picture.red(12, 32), 255);
        EXPECT_EQ(picture.red(12, 20), 0) << "the rigid one does not";
    }
}

TEST(Geometry, EveryViewOfAnInstantHasItsPicture) {
    Renderer& renderer = cpu_renderer();
    std::vector<View> views;
    for (std::uint32_t i = 0; i < 4; ++i) {
        TestCamera camera{.size = {32, 24}, .focal_px = 32};
        camera.eye = {0, 100.0 * i, 0};
        views.push_back(camera.view(i + 1));
        views.back().sequence = i;
    }
    TestWorld world;
    for (std::uint32_t i = 0; i < 4; ++i) {
        const float grey = 0.2f + 0.2f * static_cast<float>(i);
        world.objects.push_back(
            instance_of(model_of(rectangle({2, 0, 0}, {0, -4, 0}, {0, 0, 4}), colored(glm::vec3(grey), true)),
                        {0, 100.0 * i, 0}, i + 1));
    }
    const auto first = renderer.draw(world.snapshot(1000), 11, views);
    ASSERT_TRUE(first.has_value());
    ASSERT_EQ(first->set.frames.size(), 4u);
    EXPECT_EQ(first->set.world_ns, 1000);
    for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(first->set.frames[i]->info().sequence, i);
        EXPECT_EQ(first->set.frames[i]->info().monotonic_ns, 11);
        EXPECT_NEAR(Picture{first->set.frames[i]}.red(16, 12), srgb_code(0.2 + 0.2 * i), 1);
    }
    const auto second = renderer.draw(world.snapshot(2000), 12, std::span(views).subspan(2, 1));
    ASSERT_TRUE(second.has_value());
    EXPECT_EQ(second->set.world_ns, 2000);
    EXPECT_EQ(second->set.frames.at(0)->info().sequence, 2);
}

TEST(Geometry, APictureTheDeviceCannotDrawCostsItselfAndNotTheInstant) {
    std::vector<View> views{TestCamera{}.view(1), TestCamera{}.view(2)};
    auto too_large = std::make_shared<world::CameraSpec>(*views[0].spec);
    too_large->size = {100000, 16};
    views[0].spec = too_large;
    Renderer& renderer = cpu_renderer();
    const auto finished = renderer.draw(TestWorld{}.snapshot(), 0, views);
    ASSERT_TRUE(finished.has_value());
    EXPECT_EQ(finished->set.frames.size(), 1u);
    ASSERT_EQ(finished->failures.size(), 1u);
    EXPECT_EQ(finished->failures[0].camera, CameraId{1});
}

TEST(Geometry, EverySizeFromTheSmallestOnIsDrawnToItsLastPixel) {
    TestWorld world;
    world.objects = {instance_of(model_of(rectangle({2, 0, 0}, {0, -40, 0}, {0, 0, 40}), colored(glm::vec3(1), true)))};
    for (const ImageSize size : {ImageSize{16, 16}, ImageSize{17, 31}, ImageSize{65, 63}, ImageSize{641, 479}}) {
        const Picture picture = draw(world, {.size = size});
        for (const auto& [x, y] :
             {std::pair{0, 0}, {size.width - 1, 0}, {0, size.height - 1}, {size.width - 1, size.height - 1}}) {
            EXPECT_EQ(picture.at(x, y), (std::array{255, 255, 255, 255})) << size.to_string();
        }
    }
}

}  // namespace
}  // namespace camrig::render
