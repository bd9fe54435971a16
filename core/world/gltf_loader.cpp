#include "core/world/gltf_loader.h"

#include <new>

#include "core/world/gltf/animation_reader.h"
#include "core/world/gltf/material_reader.h"
#include "core/world/gltf/mesh_reader.h"
#include "core/world/gltf/node_reader.h"
#include "core/world/gltf/resources.h"

namespace camrig::world {
namespace {

/// The color of a variant goes with the vertices' (forward.vert), so there must be some.
void color_vertices_of_variants(Model& model, gltf::Budget& budget) {
    for (Mesh& mesh : model.meshes)
        for (Primitive& primitive : mesh.primitives) {
            if (primitive.material < 0 || !primitive.colors.empty()) continue;
            if (model.materials[static_cast<std::size_t>(primitive.material)].variants.colors.empty()) continue;
            budget.take(primitive.positions.size() * sizeof(glm::vec4), "meshes");
            primitive.colors.assign(primitive.positions.size(), glm::vec4(1.0f));
        }
}

ModelRef read_model(std::span<const std::byte> bytes, const std::filesystem::path& base, std::string_view name) {
    gltf::Budget budget;
    const gltf::Document document = gltf::parse_document(bytes, base, budget);
    const gltf::AccessorReader accessors(document, budget);
    auto model = std::make_shared<Model>();
    model->name = name;
    model->materials = gltf::read_materials(document);
    model->textures = gltf::read_textures(document);
    model->images = gltf::read_images(document, budget);
    model->meshes = gltf::read_meshes(document, accessors, budget);
    color_vertices_of_variants(*model, budget);
    gltf::read_nodes(document, accessors, budget, *model);
    model->animations = gltf::read_animations(document, accessors, *model);
    return model;
}

/// Runs a reader and turns everything it throws into an error that starts with the model's name.
template <typename Read>
Result<ModelRef> guarded(std::string_view name, Read&& read) {
    try {
        return read();
    } catch (const gltf::Failure& failure) {
        return at(name, failure.error);
    } catch (const std::bad_alloc&) {
        return error(ErrorKind::resource_exhausted, std::string(name) + ": not enough memory for this model");
    } catch (const std::exception& problem) {  // nlohmann::json, where a type was not foreseen
        return error(ErrorKind::invalid_argument,
                     std::string(name) + ": malformed glTF: " + std::string(problem.what()).substr(0, 200));
    }
}

}  // namespace

int Model::find_animation(std::string_view clip) const {
    for (std::size_t i = 0; i < animations.size(); ++i)
        if (animations[i].name == clip) return static_cast<int>(i);
    return -1;
}

Result<ModelRef> load_model(const std::filesystem::path& file) {
    return guarded(file.string(), [&] {
        const auto bytes = gltf::read_file(file, gltf::max_file_bytes);
        const auto base = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
        return read_model(bytes, base, file.stem().string());
    });
}

Result<ModelRef> load_model(std::span<const std::byte> bytes, const std::filesystem::path& base,
                            std::string_view name) {
    return guarded(name, [&] {
        if (bytes.size() > gltf::max_file_bytes)
            gltf::fail("", "is larger than " + std::to_string(gltf::max_file_bytes >> 20) + " MB",
                       ErrorKind::resource_exhausted);
        return read_model(bytes, base, name);
    });
}

}  // namespace camrig::world
