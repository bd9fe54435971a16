#include "core/world/look.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/world/gltf_loader.h"
#include "core/world/world.h"
#include "tests/unit/world/glb_builder.h"
#include "tests/unit/world/world_fixture.h"

namespace camrig::world::look_test {
namespace {

using namespace world_test;
using nlohmann::json;
using testing::HasSubstr;

/// A triangle with the first of these materials.
Result<ModelRef> with_materials(const std::vector<json>& materials) {
    GlbBuilder glb;
    glb.mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{"material", 0}});
    glb.json["materials"] = materials;
    return load_model(glb.build(), {}, "test");
}

json variants(json what) {
    return {{"extras", {{"camrig_variants", std::move(what)}}}};
}

ModelRef dressed() {
    const json coat{{"colors", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {"dye", "coat"}};
    return with_materials({variants(coat), variants(coat),
                           variants({{"choice", "hat"}, {"from", 0.0}, {"to", 0.5}, {"shown", false}}),
                           variants({{"choice", "hat"}, {"from", 0.5}, {"to", 1.0}}), json::object()})
        .value();
}

TEST(Looks, AModelWithoutVariantsIsAsItsFileHasIt) {
    const ModelRef plain = with_materials({json::object()}).value();
    EXPECT_TRUE(look_of(*plain, std::nullopt).empty());
    EXPECT_TRUE(look_of(*plain, 7).empty());
}

TEST(Looks, WithoutANumberWhatIsNotShownIsHiddenAndColorsAreTheFiles) {
    const Look look = look_of(*dressed(), std::nullopt);
    ASSERT_EQ(look.size(), 5u);
    EXPECT_TRUE(look[2].is_hidden);
    for (const std::size_t i : {0u, 1u, 3u, 4u}) EXPECT_FALSE(look[i].is_hidden);
    for (const MaterialLook& material : look) EXPECT_EQ(material.tint, glm::vec3(1.0f));
}

TEST(Looks, OneOfAChoiceIsThereAndOneDyeHasOneColor) {
    std::set<std::pair<bool, float>> seen;
    for (std::uint64_t variant = 0; variant < 100; ++variant) {
        const Look look = look_of(*dressed(), variant);
        ASSERT_EQ(look.size(), 5u);
        EXPECT_NE(look[2].is_hidden, look[3].is_hidden);
        EXPECT_EQ(look[0].tint, look[1].tint);
        EXPECT_EQ(look[0].tint.r + look[0].tint.g + look[0].tint.b, 1.0f);
        seen.emplace(look[2].is_hidden, look[0].tint.r + 2 * look[0].tint.g);
    }
    EXPECT_EQ(seen.size(), 6u);  // each hat with each color
}

TEST(Looks, TheColorIsThatOfTheVariantWhateverTheFileHas) {
    json material = variants({{"colors", {{0.5, 0.25, 0.125}}}});
    material["pbrMetallicRoughness"]["baseColorFactor"] = {0.25, 0.5, 0.5, 1.0};
    const ModelRef model = with_materials({material}).value();
    const Look look = look_of(*model, 3);
    ASSERT_EQ(look.size(), 1u);
    EXPECT_EQ(look[0].tint * glm::vec3(model->materials[0].base_color), glm::vec3(0.5f, 0.25f, 0.125f));
    // OpenGL has it by the vertices' colors.
    EXPECT_EQ(model->meshes[0].primitives[0].colors.size(), 3u);
}

TEST(Looks, TheColorMayHaveWhatTheFilesHasNot) {
    json material = variants({{"colors", {{0.0, 0.25, 1.0}}}});
    material["pbrMetallicRoughness"]["baseColorFactor"] = {1.0, 0.0, 0.0, 1.0};
    const ModelRef model = with_materials({material}).value();
    const glm::vec3 color = look_of(*model, 3).at(0).tint * glm::vec3(model->materials[0].base_color);
    EXPECT_NEAR(glm::distance(color, glm::vec3(0.0f, 0.25f, 1.0f)), 0.0f, 1e-6f);
}

TEST(Looks, WrongVariantsAreErrorsWithTheirPlace) {
    const std::pair<json, const char*> cases[] = {
        {json::array(), "materials[0].extras.camrig_variants: expected an object"},
        {{{"colors", json::array()}}, "camrig_variants.colors: expected 1 to 1024 colors"},
        {{{"colors", {{1, 0}}}}, "camrig_variants.colors: expected colors [r, g, b]"},
        {{{"colors", {{1, 0, 2}}}}, "camrig_variants.colors: expected a number from 0 to 1"},
        {{{"from", -1}}, "camrig_variants.from: expected a number from 0 to 1"},
        {{{"choice", 3}}, "camrig_variants.choice: expected a string"},
        {{{"shown", 1}}, "camrig_variants.shown: expected true or false"},
        {{{"hat", 1}}, "camrig_variants.hat: there are choice, colors, dye, from, shown and to"}};
    for (const auto& [wrong, message] : cases) {
        const auto model = with_materials({variants(wrong)});
        ASSERT_FALSE(model) << wrong;
        EXPECT_THAT(model.error().message, HasSubstr(message));
    }
}

TEST(Looks, AnActorHasItsVariantAndIsGivenAnother) {
    auto scene = empty_scene();
    scene->models.at("man").model = dressed();
    auto world = World::create(scene, 1).value();
    ActorSpec spec;
    spec.name = "anna";
    spec.model = "man";
    spec.variant = 5;
    const auto spawned = world->spawn_actor(spec);
    ASSERT_TRUE(spawned) << spawned.error().message;
    EXPECT_EQ(spawned->variant, 5u);
    const auto look_now = [&] {
        world->advance_to(world->last_step_ns() + scene->step_ns);
        return world->snapshot(world->last_step_ns())->movers.at(0).info->look;
    };
    EXPECT_EQ(look_now()[0].tint, look_of(*dressed(), 5)[0].tint);
    std::uint64_t other = 6;
    while (look_of(*dressed(), other)[0].tint == look_of(*dressed(), 5)[0].tint) ++other;
    ActorPatch patch;
    patch.name = "anna";
    patch.variant = other;
    ASSERT_TRUE(world->change_actor(patch));
    EXPECT_EQ(look_now()[0].tint, look_of(*dressed(), other)[0].tint);
    EXPECT_EQ(world->actors().at(0).variant, other);
}

TEST(Looks, AHundredPeopleOfTheCrowdDiffer) {
    const auto scene = load_scene("scenes/crowd.json");
    ASSERT_TRUE(scene) << scene.error().message;
    std::set<std::string> seen;
    for (const ActorSpec& actor : (*scene)->actors) {
        ASSERT_TRUE(actor.variant) << actor.name;
        std::string look = actor.model;
        for (const MaterialLook& material : look_of(*(*scene)->models.at(actor.model).model, actor.variant))
            look += " " + std::to_string(material.is_hidden) + std::to_string(material.tint.r) +
                    std::to_string(material.tint.g) + std::to_string(material.tint.b);
        EXPECT_TRUE(seen.insert(look).second) << actor.name << " looks like another";
    }
    EXPECT_EQ(seen.size(), 100u);
}

}  // namespace
}  // namespace camrig::world::look_test
