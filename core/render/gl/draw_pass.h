#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/render/gl/beautiful_inputs.h"
#include "core/render/gl/gpu_scene.h"
#include "core/render/gl/pass_view.h"
#include "core/render/gl/shader_cache.h"
#include "core/render/gl/uniform_blocks.h"

namespace camrig::render::gl {

/// Issues the draws of one picture after another. Knows GL state, nothing of cameras, frames or caches.
///
/// Neighbours that differ in nothing but their mesh and their place may be one multi-draw (`batches`): the driver looks
/// at its state once. Their order stays, so that of surfaces in one plane the same one is seen.
class DrawPass {
public:
    DrawPass(const GlFunctions& gl, ShaderCache& shaders, bool batches)
        : gl_(gl), shaders_(shaders), batches_(batches) {}

    /// Global state that no draw changes; once per instant.
    void begin_instant();
    void begin_view(const PassView& view, GpuScene& scene);

    const scene::SceneView& view() const { return view_; }

    /// Into the bound framebuffer: opaque and masked surfaces, in the given order.
    void draw_opaque(std::span<const scene::SeenSurface> draws);
    /// Farthest first, without writing depth.
    void draw_blended(std::vector<scene::SeenSurface>& draws);
    /// The same for several lists one after the other: each draw_sorted() between begin_ and end_blending().
    void begin_blending();
    void draw_sorted(std::vector<scene::SeenSurface>& draws);
    void end_blending();
    void draw_truth(std::span<const scene::SeenSurface> draws);

    /// Distances from lights, between begin_shadows() and end_shadows(): of the statics or the movers, those that
    /// cast shadows, into the depth of `framebuffer`, cleared before if `clears`, with meshes true to
    /// `max_error_m`. Afterwards begin_instant() is needed.
    void begin_shadows(int side);
    void draw_shadows(GLuint framebuffer, bool clears, const ShadowView& shadow, GpuScene& scene, bool of_statics,
                      double max_error_m);
    void end_shadows();

    std::uint64_t draws() const { return draws_; }
    std::uint64_t draw_calls() const { return draw_calls_; }
    std::uint64_t coarse_draws() const { return coarse_draws_; }

private:
    template <typename Block>
    void bind_block(GLuint binding, const Block& block);
    template <typename Entry>
    void bind_storage(GLuint binding, const std::vector<Entry>& entries);
    /// What mirrors show, where there is baked light.
    void bind_reflections();
    void use_program(GLuint program);
    void use_material(const GpuSurface& surface);
    void use_lights(const scene::PlacedSurface& surface);
    /// The light around each of a batch.
    void bind_surroundings(std::span<const scene::SeenSurface> batch);
    void use_sides(const scene::SeenSurface& seen, bool both);
    /// Then its shader is one of batches, also where it is drawn alone: in each picture the same one.
    bool may_be_batched(const GpuSurface& surface) const;
    /// The first of `draws` and those behind it that may be drawn with it.
    std::span<const scene::SeenSurface> batch_of(std::span<const scene::SeenSurface> draws) const;
    GLuint color_program(const scene::SeenSurface& seen);
    void use_vertices(const scene::SeenSurface& seen);
    /// A batch, or one draw.
    void draw(std::span<const scene::SeenSurface> batch);
    void draw_as(std::span<const scene::SeenSurface> batch, bool both_sides);
    /// Binds a range of the uniform buffer that holds the blocks of `count` draws; the caller fills it.
    template <typename Block>
    Block* bind_blocks(GLuint binding, std::size_t count);
    void use_depth_program(const GpuSurface& surface, GLuint (ShaderCache::*program)(DepthKey), bool batched);

    const GlFunctions& gl_;
    ShaderCache& shaders_;
    bool batches_;
    PassView view_;
    std::optional<BeautifulInputs> beautiful_;
    GpuScene* scene_ = nullptr;
    std::vector<StreamBuffer::Piece> light_blocks_;  ///< per light set of this view; made on first use
    // What is bound, to leave out calls that change nothing.
    GLuint program_ = 0;
    const GpuMaterial* material_ = nullptr;
    int light_set_ = -1;
    int sides_ = -1;
    // Arguments of a multi-draw.
    std::vector<GLsizei> counts_;
    std::vector<const void*> offsets_;
    std::vector<GLint> base_vertices_;
    std::uint64_t draws_ = 0, draw_calls_ = 0, coarse_draws_ = 0;
};

}  // namespace camrig::render::gl
