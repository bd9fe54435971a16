#include "core/render/scene/draw_order.h"

#include <gmock/gmock.h>

namespace camrig::render::scene {
namespace {

world::Primitive surface(int material, bool has_normals) {
    world::Primitive primitive;
    primitive.positions.resize(3);
    if (has_normals) primitive.normals.resize(3);
    primitive.material = material;
    return primitive;
}

TEST(DrawOrder, BringsTogetherWhatAgreesAndElseKeepsTheOrderOfTheFile) {
    world::Model model;
    model.meshes.resize(2);
    model.meshes[0].primitives = {surface(1, true), surface(0, true), surface(1, false)};
    model.meshes[1].primitives = {surface(1, true)};
    model.nodes.resize(4);
    model.nodes[0].mesh = 0;
    model.nodes[1].mesh = 1;
    model.nodes[3].mesh = 0;
    model.order = {3, 2, 1, 0};  // node 2 has no mesh

    std::vector<std::pair<int, int>> order;
    for (const Surface& drawn : draw_order(model)) order.emplace_back(drawn.node, drawn.primitive);
    using testing::Pair;
    EXPECT_THAT(order, testing::ElementsAre(Pair(3, 2), Pair(0, 2), Pair(3, 1), Pair(0, 1), Pair(3, 0), Pair(1, 0),
                                            Pair(0, 0)));
}

}  // namespace
}  // namespace camrig::render::scene
