#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/render/gl/gpu_model.h"
#include "core/render/gl/stream_buffer.h"
#include "core/render/scene/scene_view.h"

namespace camrig::render::gl {

/// What OpenGL has of a placed surface.
struct GpuSurface {
    const GpuModel* model = nullptr;
    const GpuPrimitive* primitive = nullptr;
    const GpuMaterial* material = nullptr;
    ShaderKey key;  ///< all but the quality
    /// Per Quality, then the same with fog; 0 until first drawn.
    std::array<GLuint, 6> programs{};
};

/// Deformed vertices on the device.
struct GpuVertices {
    StreamBuffer::Piece positions, normals;
};

/// A placed scene as the device has it: models are uploaded when they are first seen, deformed vertices when they are
/// first drawn in an instant.
class GpuScene {
public:
    GpuScene(const GlFunctions& gl, SamplerCache& samplers, std::shared_ptr<scene::PreparedModels> prepared)
        : gl_(gl), samplers_(samplers), scene_(std::move(prepared)), static_stream_(gl), stream_(gl) {}

    /// Becomes the scene of this instant. The device must be done with the one before.
    void place(const world::SnapshotRef& snapshot);
    void clear();

    const scene::PlacedScene& placed() const { return scene_; }
    GpuSurface& of(const scene::PlacedSurface& surface, bool is_static) {
        return group(is_static).surfaces[surface.index];
    }
    GpuSurface& of(const scene::SeenSurface& seen) { return of(*seen.placed, seen.is_static); }
    const GpuVertices& deformed(const scene::SeenSurface& seen);
    /// For what is written once an instant.
    StreamBuffer& stream() { return stream_; }
    std::size_t stream_bytes() const { return static_stream_.capacity() + stream_.capacity(); }

private:
    struct Group {
        std::vector<GpuSurface> surfaces;   ///< as of PlacedSurfaces::all
        std::vector<GpuVertices> deformed;  ///< one per deformation there; buffer 0 until uploaded
    };
    Group& group(bool is_static) { return is_static ? statics_ : movers_; }
    void take(const scene::PlacedSurfaces& placed, Group& group);

    const GlFunctions& gl_;
    SamplerCache& samplers_;
    scene::ModelCache<GpuModel> models_;
    scene::PlacedScene scene_;
    Group statics_, movers_;
    StreamBuffer static_stream_, stream_;
};

}  // namespace camrig::render::gl
