#include "core/render/gl/draw_pass.h"

#include <algorithm>
#include <cstring>

#include "core/render/gl/pass_uniforms.h"
#include "core/render/scene/shadow_casters.h"

namespace camrig::render::gl {

void DrawPass::begin_instant() {
    // y = -1 is the top row by the projection itself, so window origin and row order stay GL's own; the mirrored y
    // turns counter-clockwise triangles into clockwise ones (use_sides).
    gl_.ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    gl_.Enable(GL_DEPTH_TEST);
    gl_.DepthFunc(GL_GREATER);
    gl_.CullFace(GL_BACK);
    // An instant that memory ended may have left these as they were within a pass.
    end_blending();
    end_shadows();
    gl_.Disable(GL_SCISSOR_TEST);
    program_ = 0;
    material_ = nullptr;
    sides_ = -1;
}

void DrawPass::begin_view(const PassView& view, GpuScene& scene) {
    view_ = view;
    scene_ = &scene;
    material_ = nullptr;  // samplers differ by quality
    light_blocks_.assign(static_cast<std::size_t>(view.scene->light_sets().size()), {});
    light_set_ = -1;

    bind_block(view_binding, view_block(view));
    if (view.quality != world::Quality::beautiful) return;
    if (!beautiful_) beautiful_.emplace(gl_);
    beautiful_->bind(view.shadow_maps, view.light_map == nullptr ? 0 : view.light_map->texture());
    if (!view.shadows.empty()) bind_block(shadow_binding, shadow_block(view));
    bind_reflections();
    if (view.bodies == nullptr) return;
    bind_storage(body_binding, view.bodies->bodies);
    bind_storage(capsule_binding, view.bodies->capsules);
}

void DrawPass::bind_reflections() {
    if (view_.light_map == nullptr) return;
    bind_block(reflection_binding, reflection_block(view_));
    if (view_.light_map->reflection_texels() == 0) return;
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, reflection_texel_binding, view_.light_map->reflection_texels());
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, nearness_binding, view_.light_map->nearness());
}

template <typename Block>
void DrawPass::bind_block(GLuint binding, const Block& block) {
    const auto piece = scene_->stream().allocate(sizeof block);
    std::memcpy(piece.data, &block, sizeof block);
    gl_.BindBufferRange(GL_UNIFORM_BUFFER, binding, piece.buffer, piece.offset, sizeof block);
}

template <typename Entry>
void DrawPass::bind_storage(GLuint binding, const std::vector<Entry>& entries) {
    if (entries.empty()) return;
    const std::size_t bytes = entries.size() * sizeof(Entry);
    const auto piece = scene_->stream().allocate(bytes);
    std::memcpy(piece.data, entries.data(), bytes);
    gl_.BindBufferRange(GL_SHADER_STORAGE_BUFFER, binding, piece.buffer, piece.offset, static_cast<GLsizeiptr>(bytes));
}

void DrawPass::use_program(GLuint program) {
    if (program == program_) return;
    gl_.UseProgram(program);
    program_ = program;
}

void DrawPass::use_material(const GpuSurface& surface) {
    if (surface.material == material_) return;
    material_ = surface.material;
    gl_.BindBufferRange(GL_UNIFORM_BUFFER, material_binding, surface.model->uniforms.name(), material_->block_offset,
                        sizeof(MaterialBlock));
    for (GLuint unit = 0; unit < texture_use_count; ++unit) {
        const GpuTexture& texture = material_->textures[unit];
        if (texture.texture == 0) continue;
        gl_.BindTextureUnit(unit, texture.texture);
        gl_.BindSampler(unit, texture.samplers[static_cast<std::size_t>(view_.quality)]);
    }
}

void DrawPass::use_lights(const scene::PlacedSurface& surface) {
    if (surface.light_set == light_set_) return;
    light_set_ = surface.light_set;
    const scene::LightSet set = lights_of(view_, surface);
    const std::size_t bytes = light_bytes(view_, set);
    if (bytes == 0) return;
    StreamBuffer::Piece& piece = light_blocks_[static_cast<std::size_t>(light_set_)];
    if (piece.data == nullptr) {
        piece = scene_->stream().allocate(bytes);
        write_lights(view_, set, piece.data);
    }
    gl_.BindBufferRange(GL_UNIFORM_BUFFER, light_binding, piece.buffer, piece.offset, static_cast<GLsizeiptr>(bytes));
}

void DrawPass::use_sides(const scene::SeenSurface& seen, bool both) {
    const bool is_double = both || scene_->of(seen).material->double_sided, turns = seen.placed->turns_clockwise;
    const int sides = is_double ? 2 + turns : static_cast<int>(turns);
    if (sides == sides_) return;
    sides_ = sides;
    gl_.FrontFace(turns ? GL_CCW : GL_CW);
    if (is_double) {
        gl_.Disable(GL_CULL_FACE);
    } else {
        gl_.Enable(GL_CULL_FACE);
    }
}

bool DrawPass::may_be_batched(const GpuSurface& surface) const {
    return batches_ && !surface.primitive->may_deform;
}

std::span<const scene::SeenSurface> DrawPass::batch_of(std::span<const scene::SeenSurface> draws) const {
    const scene::SeenSurface& first = draws.front();
    const GpuSurface& surface = scene_->of(first);
    if (!may_be_batched(surface)) return draws.first(1);
    const auto fits = [&](const scene::SeenSurface& seen) {
        const GpuSurface& other = scene_->of(seen);
        // One vertex array and one material: the same shader.
        return other.material == surface.material && other.primitive->vertex_array == surface.primitive->vertex_array &&
               seen.placed->light_set == first.placed->light_set &&
               seen.placed->turns_clockwise == first.placed->turns_clockwise &&
               light_around(view_, *seen.placed) == light_around(view_, *first.placed);
    };
    draws = draws.first(std::min(draws.size(), max_batch));
    return {draws.begin(), std::ranges::find_if_not(draws, fits)};
}

void DrawPass::use_vertices(const scene::SeenSurface& seen) {
    const GpuSurface& surface = scene_->of(seen);
    const GpuPrimitive& primitive = *surface.primitive;
    gl_.BindVertexArray(primitive.vertex_array);
    if (!primitive.may_deform) return;
    const auto fetch_from = [&](GLuint positions, GLintptr position_offset, GLuint normals, GLintptr normal_offset) {
        constexpr GLsizei stride = sizeof(glm::vec3);
        gl_.VertexArrayVertexBuffer(primitive.vertex_array, attribute_position, positions, position_offset, stride);
        if (!primitive.layout.has_normals) return;
        gl_.VertexArrayVertexBuffer(primitive.vertex_array, attribute_normal, normals, normal_offset, stride);
    };
    if (seen.placed->deformation >= 0) {
        const auto& [positions, normals] = scene_->deformed(seen);
        fetch_from(positions.buffer, positions.offset, normals.buffer, normals.offset);
    } else {
        // The same mesh without a skin elsewhere in the file: back to the vertices as they were loaded.
        const GLuint loaded = surface.model->vertices.name();
        fetch_from(loaded, primitive.position_offset, loaded, primitive.normal_offset);
    }
}

template <typename Block>
Block* DrawPass::bind_blocks(GLuint binding, std::size_t count) {
    // The block of a shader must be bound whole, however many draws there are.
    constexpr std::size_t bound = max_batch * sizeof(Block);
    const auto piece = scene_->stream().allocate(count * sizeof(Block), bound);
    gl_.BindBufferRange(GL_UNIFORM_BUFFER, binding, piece.buffer, piece.offset, GLsizeiptr{bound});
    return reinterpret_cast<Block*>(piece.data);
}

void DrawPass::bind_surroundings(std::span<const scene::SeenSurface> batch) {
    std::ranges::transform(batch, bind_blocks<SurroundingsBlock>(surroundings_binding, batch.size()),
                           [&](const scene::SeenSurface& seen) { return surroundings_block(view_, *seen.placed); });
}

void DrawPass::draw(std::span<const scene::SeenSurface> batch) {
    std::ranges::transform(batch, bind_blocks<DrawBlock>(draw_binding, batch.size()), draw_block);
    draw_as(batch, false);
}

void DrawPass::draw_as(std::span<const scene::SeenSurface> batch, bool both_sides) {
    const GpuPrimitive& primitive = *scene_->of(batch.front()).primitive;
    use_sides(batch.front(), both_sides);
    use_vertices(batch.front());
    counts_.clear();
    offsets_.clear();
    base_vertices_.clear();
    for (const scene::SeenSurface& seen : batch) {
        const GpuPrimitive& own = *scene_->of(seen).primitive;
        const IndexRange& range = own.levels[static_cast<std::size_t>(seen.level)];
        counts_.push_back(range.count);
        offsets_.push_back(reinterpret_cast<const void*>(range.offset));
        base_vertices_.push_back(own.base_vertex);
        coarse_draws_ += seen.level > 0;
    }
    draws_ += batch.size();
    ++draw_calls_;
    if (batch.size() == 1) {
        gl_.DrawElementsBaseVertex(primitive.mode, counts_[0], primitive.index_type, offsets_[0], base_vertices_[0]);
    } else {
        gl_.MultiDrawElementsBaseVertex(primitive.mode, counts_.data(), primitive.index_type, offsets_.data(),
                                        static_cast<GLsizei>(batch.size()), base_vertices_.data());
    }
}

GLuint DrawPass::color_program(const scene::SeenSurface& seen) {
    GpuSurface& surface = scene_->of(seen);
    const bool has_fog = view_.fog().per_m > 0.0f;
    GLuint& program = surface.programs[static_cast<std::size_t>(view_.quality) + (has_fog ? 3 : 0)];
    if (program != 0) return program;
    ShaderKey key = surface.key;
    key.quality = view_.quality;
    key.has_fog = has_fog;
    key.batched = may_be_batched(surface);
    key.light_around = light_around(view_, *seen.placed);
    const scene::LightSet set = lights_of(view_, *seen.placed);
    for (int i = 0; i < set.directional + set.local; ++i)
        key.has_shadows |= !shadow_maps_of(view_, set.lights[i]).empty();
    program = shaders_.program(key);
    return program;
}

void DrawPass::draw_opaque(std::span<const scene::SeenSurface> draws) {
    while (!draws.empty()) {
        const auto batch = batch_of(draws);
        draws = draws.subspan(batch.size());
        const scene::SeenSurface& first = batch.front();
        const GpuSurface& surface = scene_->of(first);
        use_program(color_program(first));
        use_material(surface);
        if (surface.key.lit) use_lights(*first.placed);
        if (light_around(view_, *first.placed) == LightAround::surroundings) bind_surroundings(batch);
        draw(batch);
    }
}

void DrawPass::begin_blending() {
    // Blending is linear light, so here the target encodes; switching it on costs a CPU rasteriser a flush.
    gl_.Enable(GL_FRAMEBUFFER_SRGB);
    gl_.Enable(GL_BLEND);
    // Glass hides of each color another share. Alpha stays 255 in the picture whatever is blended over it.
    gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC1_COLOR, GL_ZERO, GL_ONE);
    gl_.DepthMask(GL_FALSE);
}

void DrawPass::end_blending() {
    gl_.DepthMask(GL_TRUE);
    gl_.Disable(GL_BLEND);
    // Nothing is drawn into several targets while there is a factor of a second source, blended or not.
    gl_.BlendFuncSeparate(GL_ONE, GL_ZERO, GL_ONE, GL_ZERO);
    gl_.Disable(GL_FRAMEBUFFER_SRGB);
}

void DrawPass::draw_sorted(std::vector<scene::SeenSurface>& draws) {
    sort_far_to_near(draws);
    draw_opaque(draws);
}

void DrawPass::draw_blended(std::vector<scene::SeenSurface>& draws) {
    if (draws.empty()) return;
    begin_blending();
    draw_sorted(draws);
    end_blending();
}

void DrawPass::use_depth_program(const GpuSurface& surface, GLuint (ShaderCache::*program)(DepthKey), bool batched) {
    const bool is_masked = surface.key.alpha_mode == world::AlphaMode::mask;
    use_program((shaders_.*program)({.masked = is_masked,
                                     .uv1 = (surface.key.uv_sets & 1) != 0,
                                     .has_color = surface.key.has_color,
                                     .textured = surface.key.uv_slots[static_cast<int>(TextureUse::base_color)] >= 0,
                                     .batched = batched}));
    if (is_masked) use_material(surface);
}

void DrawPass::draw_truth(std::span<const scene::SeenSurface> draws) {
    while (!draws.empty()) {
        const auto batch = batch_of(draws);
        draws = draws.subspan(batch.size());
        const GpuSurface& surface = scene_->of(batch.front());
        use_depth_program(surface, &ShaderCache::truth_program, may_be_batched(surface));
        draw(batch);
    }
}

void DrawPass::begin_shadows(int side) {
    begin_instant();
    view_.quality = world::Quality::beautiful;  // as which materials are sampled
    gl_.DepthFunc(GL_LESS);
    gl_.Enable(GL_DEPTH_CLAMP);
    gl_.Viewport(0, 0, side, side);
}

void DrawPass::end_shadows() {
    gl_.Disable(GL_DEPTH_CLAMP);
}

void DrawPass::draw_shadows(GLuint framebuffer, bool clears, const ShadowView& shadow, GpuScene& scene, bool of_statics,
                            double max_error_m) {
    scene_ = &scene;
    const float farthest = 1.0f;
    if (clears) gl_.ClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, &farthest);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    for (const scene::PlacedSurface& placed : scene.placed().group_of(of_statics).all()) {
        if (!casts_shadow(placed)) continue;
        const glm::dmat4 map_from_local = shadow.map_from(placed.world_from_local);
        if (!may_be_visible(shadow.frustum, map_from_local, placed.bounds.min, placed.bounds.max)) continue;
        const scene::SeenSurface seen{
            .placed = &placed, .is_static = of_statics, .level = shadow_level(placed, max_error_m)};
        use_depth_program(scene.of(seen), &ShaderCache::shadow_program, false);
        *bind_blocks<DrawBlock>(draw_binding, 1) = shadow_draw_block(shadow.clip_from_map * map_from_local);
        draw_as({&seen, 1}, true);
    }
}

}  // namespace camrig::render::gl
