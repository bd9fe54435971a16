#include "core/render/gl/gpu_scene.h"

#include <cstring>

namespace camrig::render::gl {

void GpuScene::place(const world::SnapshotRef& snapshot) {
    stream_.reset();
    const std::uint64_t statics_before = scene_.statics_number();
    scene_.place(snapshot);
    take(scene_.movers(), movers_);
    if (scene_.statics_number() != statics_before) {
        gl_.Finish();  // what is there of the statics before may still be read
        static_stream_.reset();
        take(scene_.statics(), statics_);
    }
    models_.evict_unused();
}

void GpuScene::clear() {
    statics_ = {};
    movers_ = {};
    scene_.clear();
}

void GpuScene::take(const scene::PlacedSurfaces& placed, Group& group) {
    group.surfaces.clear();
    const scene::PreparedModel* last = nullptr;
    const GpuModel* model = nullptr;
    for (const scene::PlacedSurface& surface : placed.all()) {
        if (surface.model != last) {
            last = surface.model;
            const world::ModelRef& source = *surface.source;
            model = &models_.of(source, [&](const world::ModelRef& made) {
                return upload_model(gl_, samplers_, *made, *surface.model);
            });
        }
        GpuSurface& entry = group.surfaces.emplace_back();
        entry.model = model;
        entry.primitive = &model->primitives[surface.primitive->number];
        entry.material = &model->materials[static_cast<std::size_t>(entry.primitive->material)];
        entry.key = entry.primitive->key;
        // Tangents are not carried along; the shader derives a frame from the picture instead.
        if (surface.deformation >= 0) entry.key.has_tangent = false;
        const scene::LightSet& lights = scene_.light_sets()[surface.light_set];
        entry.key.directional_lights = lights.directional;
        entry.key.local_lights = lights.local;
    }
    group.deformed.assign(placed.deformation_count(), {});
}

const GpuVertices& GpuScene::deformed(const scene::SeenSurface& seen) {
    const scene::PlacedSurface& surface = *seen.placed;
    GpuVertices& vertices = group(seen.is_static).deformed[static_cast<std::size_t>(surface.deformation)];
    if (vertices.positions.data != nullptr) return vertices;
    const scene::DeformedVertices& made = (seen.is_static ? scene_.statics() : scene_.movers()).deform(surface);
    StreamBuffer& stream = seen.is_static ? static_stream_ : stream_;
    const auto upload = [&](const std::vector<glm::vec3>& values) {
        const std::size_t bytes = values.size() * sizeof(glm::vec3);
        const StreamBuffer::Piece piece = stream.allocate(bytes);
        std::memcpy(piece.data, values.data(), bytes);
        return piece;
    };
    vertices = {.positions = upload(made.positions), .normals = upload(made.normals)};
    return vertices;
}

}  // namespace camrig::render::gl
