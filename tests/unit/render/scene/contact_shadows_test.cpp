#include "core/render/scene/contact_shadows.h"

#include <gmock/gmock.h>

#include "core/render/scene/scene_view.h"
#include "tests/render/support/test_models.h"

namespace camrig::render::scene {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

/// Two feet of 0.1 x 0.3 x 0.1 m, each on a joint of its own (nodes 1 and 2).
world::ModelRef feet() {
    const world::Primitive foot = box({0.05f, 0.15f, 0.05f});
    world::Primitive both = foot;
    both.joints.assign(foot.positions.size(), glm::u16vec4(0));
    for (const std::uint32_t index : foot.indices)
        both.indices.push_back(index + static_cast<std::uint32_t>(foot.positions.size()));
    both.positions.insert(both.positions.end(), foot.positions.begin(), foot.positions.end());
    both.normals.insert(both.normals.end(), foot.normals.begin(), foot.normals.end());
    both.texcoords[0].clear();
    both.joints.resize(both.positions.size(), glm::u16vec4(1, 0, 0, 0));
    both.weights.assign(both.positions.size(), glm::vec4(1, 0, 0, 0));
    const auto model = model_of(std::move(both), colored(glm::vec3(0.5f)));
    model->nodes[0].skin = 0;
    model->nodes.resize(3);
    model->order = {0, 1, 2};
    model->skins.push_back({.name = "feet", .joints = {1, 2}, .inverse_bind = {glm::dmat4(1.0), glm::dmat4(1.0)}});
    return model;
}

/// The left foot stands 0.2 m beside the middle; the sole of the right one, on the other side, is so high.
world::PosedModel pose(double right_height_m) {
    world::PosedModel pose;
    pose.model_from_node.assign(3, glm::dmat4(1.0));
    pose.model_from_node[1][3] = {0.0, 0.2, 0.05, 1.0};
    pose.model_from_node[2][3] = {0.0, -0.2, 0.05 + right_height_m, 1.0};
    return pose;
}

std::vector<ContactShadow> shadows(double right_height_m) {
    const world::ModelRef model = feet();
    const PreparedModel prepared = prepare_model(model);
    ContactShadows shadows;
    shadows.begin();
    skinned_bounds(*model, pose(right_height_m), 0, prepared.primitives[0].joint_boxes,
                   [&](int joint, const world::Box& box) { shadows.add(joint, box); });
    const auto made = shadows.find();
    return {made.begin(), made.end()};
}

glm::dvec2 middle(const ContactShadow& shadow) {
    return glm::dvec2(shadow.model_from_patch[3]);
}
glm::dvec2 half_size(const ContactShadow& shadow) {
    return {shadow.model_from_patch[0].x, shadow.model_from_patch[1].y};
}

TEST(ContactShadows, LieUnderEachFootAndWiderUnderBoth) {
    const std::vector<ContactShadow> made = shadows(0.0);
    ASSERT_THAT(made, SizeIs(3));
    EXPECT_NEAR(middle(made[0]).y, 0.2, 1e-6);
    EXPECT_NEAR(middle(made[1]).y, -0.2, 1e-6);
    EXPECT_NEAR(middle(made[2]).y, 0.0, 1e-6);
    for (int foot : {0, 1}) {
        EXPECT_EQ(made[static_cast<std::size_t>(foot)].shade, contact_shades - 1);
        EXPECT_GT(half_size(made[static_cast<std::size_t>(foot)]).x, 0.05);
        EXPECT_GT(half_size(made[static_cast<std::size_t>(foot)]).y, 0.15);
    }
    EXPECT_GT(half_size(made[2]).y, 0.35);
    EXPECT_LT(made[2].shade, made[0].shade);
    for (const ContactShadow& shadow : made) {
        EXPECT_GT(shadow.model_from_patch[3].z, 0.0) << "in the ground";
        EXPECT_LT(shadow.model_from_patch[3].z, 0.02) << "above the ground";
    }
}

TEST(ContactShadows, PaleAndWidenAsAFootRisesAndGo) {
    const std::vector<ContactShadow> low = shadows(0.0), lifted = shadows(0.08), high = shadows(0.4);
    EXPECT_EQ(lifted[1].shade, contact_shades / 2 - 1);
    EXPECT_GT(half_size(lifted[1]).x, half_size(low[1]).x);
    EXPECT_EQ(lifted[0].shade, low[0].shade) << "the foot that stands";
    ASSERT_THAT(high, SizeIs(2));
    EXPECT_NEAR(middle(high[1]).y, 0.2, 1e-6) << "the wider one lies under what is near the ground";
}

TEST(ContactShadows, OfSomebodyWhoLiesAreBounded) {
    ContactShadows shadows;
    shadows.begin();
    for (int joint = 0; joint < 100; ++joint) {
        const float y = 0.02f * static_cast<float>(joint);
        shadows.add(joint, {{0.0f, y, 0.0f}, {0.3f, y + 0.02f, 0.1f}});
    }
    const auto made = shadows.find();
    EXPECT_LT(made.size(), 20u);
    EXPECT_GT(half_size(made.back()).y, 1.0) << "the wide one lies under all";
    shadows.begin();
    EXPECT_THAT(shadows.find(), IsEmpty());
}

TEST(ContactShadows, AreSeenAtQualitySimpleAsBlendedSurfacesOfTheirObject) {
    TestWorld world;
    const world::ModelRef crate = model_of(box(glm::vec3(0.2f)), colored(glm::vec3(0.5f)));
    world.movers = {instance_of(feet(), {5, 0, -1}, 7), instance_of(crate, {6, 0, -1}, 8)};  // the crate has none
    PlacedScene scene(std::make_shared<PreparedModels>());
    scene.place(world.snapshot());
    const auto seen_at = [&](world::Quality quality) {
        SeenMovers movers;
        movers.see(make_scene_view(scene, make_view_transform({}, {64, 48}, {64.0, 64.0, 31.5, 23.5}, 0.05, 0.0), 0.0,
                                   quality, 0.0));
        EXPECT_THAT(movers.opaque, SizeIs(2));
        EXPECT_EQ(movers.rects.size(), movers.opaque.size() + movers.blended.size());
        for (const SeenSurface& seen : movers.blended) EXPECT_EQ(seen.placed->object->id, ObjectId{7});
        return movers.blended;
    };
    EXPECT_THAT(seen_at(world::Quality::fast), IsEmpty());
    EXPECT_THAT(seen_at(world::Quality::simple), testing::Not(IsEmpty()));
    EXPECT_THAT(seen_at(world::Quality::beautiful), IsEmpty()) << "there are BodiesInView";
}

}  // namespace
}  // namespace camrig::render::scene
