#include "core/render/scene/body_capsules.h"

#include <gmock/gmock.h>

#include "core/render/scene/scene_view.h"
#include "tests/render/support/test_body.h"

namespace camrig::render::scene {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

TEST(BodyCapsules, LieAboutWhatEachJointMoves) {
    // A leg of 0.2 x 0.2 x 0.8 m, whose corners are 0.1 * sqrt(2) beside its axis, under a cube.
    const std::vector<JointCapsule> body = body_of(*leg_and_cube());
    ASSERT_THAT(body, SizeIs(2));
    const JointCapsule& leg = body[0].node == 1 ? body[0] : body[1];
    EXPECT_NEAR(leg.capsule.radius_m, 0.1414, 0.001);
    EXPECT_NEAR(std::abs(leg.capsule.to.z - leg.capsule.from.z), 0.8 - 2 * 0.1414, 0.001);
    EXPECT_NEAR(leg.capsule.to.x, leg.capsule.from.x, 1e-6);
    EXPECT_NEAR(0.5 * (leg.capsule.from.z + leg.capsule.to.z), 0.0, 1e-6) << "in the frame of its joint";
    const world::ModelRef rigid = model_of(box(glm::vec3(0.2f)), colored(glm::vec3(0.5f)));
    EXPECT_THAT(body_of(*rigid), IsEmpty()) << "nothing says whether a box stands on something";
}

TEST(BodyCapsules, GoWithTheirJointsAndTheScale) {
    const world::ModelRef model = leg_and_cube();
    world::PosedModel pose;
    world::pose_model(*model, {}, pose);
    PlacedBodies placed;
    const glm::dmat4 world = world::world_from_model({3, 4, 0}, {1, 0, 0, 0}, 2.0);
    placed.add(ObjectId{7}, body_of(*model), pose, world);
    ASSERT_THAT(placed.bodies(), SizeIs(1));
    ASSERT_THAT(placed.capsules(), SizeIs(2));
    const Capsule& leg =
        placed.capsules()[0].radius_m < placed.capsules()[1].radius_m ? placed.capsules()[0] : placed.capsules()[1];
    EXPECT_NEAR(leg.radius_m, 2 * 0.1414, 0.002);
    EXPECT_NEAR(0.5 * (leg.from.z + leg.to.z), 2 * 0.4, 1e-6);
    EXPECT_NEAR(leg.from.x, 3.0, 1e-6);
    EXPECT_NEAR(placed.bodies()[0].min.z, 2 * 0.0 - contact_reach_m, 0.01) << "it reaches so far beyond its surface";
}

TEST(BodyCapsules, OfAViewAreThoseNearWhatItSees) {
    TestWorld world;
    world.objects = {instance_of(leg_and_cube(), {5, 0, -1}, 7)};
    world.movers = {instance_of(leg_and_cube(), {6, 1, -1}, 8), instance_of(leg_and_cube(), {-6, 0, -1}, 9)};
    PlacedScene scene(std::make_shared<PreparedModels>());
    scene.place(world.snapshot());
    const auto see = [&](world::Quality quality) {
        return make_scene_view(scene, make_view_transform({}, {64, 48}, {64.0, 64.0, 31.5, 23.5}, 0.05, 0.0), 0.0,
                               quality, 0.0);
    };
    EXPECT_TRUE(see(world::Quality::beautiful).has_contact_occlusion);
    EXPECT_FALSE(see(world::Quality::simple).has_contact_occlusion);
    BodiesInView bodies;
    bodies.see(see(world::Quality::beautiful), scene.statics().bodies(), scene.movers().bodies());
    ASSERT_THAT(bodies.bodies, SizeIs(2)) << "the third is behind the camera";
    EXPECT_EQ(bodies.bodies[0].object, ObjectId{7});
    EXPECT_EQ(bodies.bodies[0].is_moving, 0u);
    EXPECT_EQ(bodies.bodies[1].is_moving, 1u);
    ASSERT_THAT(bodies.moving_rects, SizeIs(1)) << "of those that move alone";
    // Optical: right is -y.
    EXPECT_LT(bodies.moving_rects[0].x0, 31);
    EXPECT_LT(bodies.bodies[1].middle.x, 0.0f);
    for (const CapsuleInView& capsule : bodies.capsules) EXPECT_NEAR(capsule.length, glm::length(capsule.along), 1e-6f);
}

}  // namespace
}  // namespace camrig::render::scene
