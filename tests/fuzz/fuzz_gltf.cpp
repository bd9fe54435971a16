// Any bytes as a model file: an error or a model that can be posed and drawn, never a crash. Input that is JSON, a NUL
// byte and more bytes is made a .glb of the two, so that a mutation of either part does not end at the chunk lengths.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/world/gltf_loader.h"
#include "core/world/model_scene.h"
#include "core/world/posed_model.h"
#include "tests/unit/world/glb_builder.h"

namespace {

using namespace camrig;

Result<world::ModelRef> load(std::span<const std::byte> bytes) {
    const auto nul = std::ranges::find(bytes, std::byte{0});
    if (bytes.empty() || bytes.front() != std::byte{'{'} || nul == bytes.end())
        return world::load_model(bytes, {}, "fuzz");
    const std::string text(reinterpret_cast<const char*>(bytes.data()), static_cast<std::size_t>(nul - bytes.begin()));
    return world::load_model(world::GlbBuilder::assemble(text, {nul + 1, bytes.end()}), {}, "fuzz");
}

void deform_all(const world::Model& model, const world::PosedModel& pose) {
    std::vector<glm::vec3> positions, normals;
    for (const int node : model.order) {
        const int mesh = model.nodes[static_cast<std::size_t>(node)].mesh;
        if (mesh < 0) continue;
        for (const world::Primitive& primitive : model.meshes[static_cast<std::size_t>(mesh)].primitives) {
            positions.resize(primitive.positions.size());
            normals.resize(primitive.positions.size());
            deform_vertices(model, pose, node, primitive, positions, normals);
        }
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto model = load(std::as_bytes(std::span(data, size)));
    if (!model) return 0;
    (void)scene_of_model(*model);
    world::PosedModel pose;
    for (std::size_t a = 0; a < (*model)->animations.size() && a < 4; ++a) {
        const world::ClipState clip{.animation = static_cast<int>(a),
                                    .phase_ns = (*model)->animations[a].duration_ns / 3};
        pose_model(**model, std::span(&clip, 1), pose);
        deform_all(**model, pose);
    }
    return 0;
}
