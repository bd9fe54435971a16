#include "core/render/gl/draw_pass.h"

#include <algorithm>
#include <cstring>

#include "core/render/detail_levels.h"
#include "core/render/gl/pass_uniforms.h"

namespace camrig {
namespace {

/// The coarsest level of a mesh whose error in metres `is_fine`.
template <typename IsFine>
const IndexRange& coarsest_range(const SceneItem& item, const IsFine& is_fine) {
    const GpuPrimitive& primitive = *item.primitive;
    const double scale = detail_error_scale(primitive.source->bounds, item.bounds, item.world_from_local);
    const IndexRange* chosen = &primitive.full;
    for (const IndexRange& level : primitive.coarser) {
        if (!is_fine(level.error * scale)) break;
        chosen = &level;
    }
    return *chosen;
}

}  // namespace

void DrawPass::begin_instant() {
    // y = -1 is the top row by the projection itself, so window origin and row order stay GL's own; the mirrored y
    // turns counter-clockwise triangles into clockwise ones (use_sides).
    gl_.ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    gl_.Enable(GL_DEPTH_TEST);
    gl_.DepthFunc(GL_GREATER);
    gl_.CullFace(GL_BACK);
    // Alpha stays 255 in the picture whatever is blended over it.
    gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
    program_ = 0;
    material_ = nullptr;
    sides_ = -1;
}

void DrawPass::begin_view(const PassView& view, StreamBuffer& stream) {
    view_ = view;
    stream_ = &stream;
    material_ = nullptr;  // samplers differ by quality
    light_blocks_.assign(static_cast<std::size_t>(view.light_sets->size()), {});
    light_set_ = -1;

    bind_block(view_binding, view_block(view));
    if (view.quality != Quality::beautiful) return;
    if (!beautiful_) beautiful_.emplace(gl_);
    beautiful_->bind(view.shadow_maps);
    if (!view.shadows.empty()) bind_block(shadow_binding, shadow_block(view));
}

template <typename Block>
void DrawPass::bind_block(GLuint binding, const Block& block) {
    const auto piece = stream_->allocate(sizeof block);
    std::memcpy(piece.data, &block, sizeof block);
    gl_.BindBufferRange(GL_UNIFORM_BUFFER, binding, piece.buffer, piece.offset, sizeof block);
}

void DrawPass::cull(SceneItems& items, std::vector<VisibleDraw>* opaque, std::vector<VisibleDraw>* blended) {
    for (SceneItem& item : items.items) {
        std::vector<VisibleDraw>* const list = item.key.alpha_mode == AlphaMode::blend ? blended : opaque;
        if (list == nullptr) continue;
        const glm::dmat4 optical_from_local = view_.transform.optical_from(item.world_from_local);
        if (!may_be_visible(view_.frustum, optical_from_local, item.bounds.min, item.bounds.max)) continue;
        VisibleDraw visible{.item = &item,
                            .owner = &items,
                            .range = &range_of(item, optical_from_local),
                            .uniforms = draw_block(optical_from_local, item)};
        const glm::dvec3 middle = 0.5 * (glm::dvec3(item.bounds.min) + glm::dvec3(item.bounds.max));
        visible.distance_m = (optical_from_local * glm::dvec4(middle, 1.0)).z;
        list->push_back(visible);
    }
}

const IndexRange& DrawPass::range_of(const SceneItem& item, const glm::dmat4& optical_from_local) const {
    if (view_.max_detail_error_px <= 0.0) return item.primitive->full;
    const double px_per_m = detail_error_px(view_.transform, optical_from_local, item.bounds, 1.0);
    return coarsest_range(item, [&](double error_m) { return error_m * px_per_m <= view_.max_detail_error_px; });
}

void DrawPass::use_program(GLuint program) {
    if (program == program_) return;
    gl_.UseProgram(program);
    program_ = program;
}

void DrawPass::use_material(const SceneItem& item) {
    if (item.material == material_) return;
    material_ = item.material;
    gl_.BindBufferRange(GL_UNIFORM_BUFFER, material_binding, item.model->uniforms.name(), material_->block_offset,
                        sizeof(MaterialBlock));
    for (GLuint unit = 0; unit < texture_use_count; ++unit) {
        const GpuTexture& texture = material_->textures[unit];
        if (texture.texture == 0) continue;
        gl_.BindTextureUnit(unit, texture.texture);
        gl_.BindSampler(unit, texture.samplers[static_cast<std::size_t>(view_.quality)]);
    }
}

void DrawPass::use_lights(int light_set) {
    if (light_set == light_set_) return;
    light_set_ = light_set;
    const LightSet& set = (*view_.light_sets)[light_set];
    const std::size_t bytes = light_bytes(view_, set);
    if (bytes == 0) return;
    StreamBuffer::Piece& piece = light_blocks_[static_cast<std::size_t>(light_set)];
    if (piece.data == nullptr) {
        piece = stream_->allocate(bytes);
        write_lights(view_, set, piece.data);
    }
    gl_.BindBufferRange(GL_UNIFORM_BUFFER, light_binding, piece.buffer, piece.offset, static_cast<GLsizeiptr>(bytes));
}

void DrawPass::use_sides(const SceneItem& item, bool both) {
    const bool is_double = both || item.material->double_sided;
    const int sides = is_double ? 2 + item.is_mirrored : static_cast<int>(item.is_mirrored);
    if (sides == sides_) return;
    sides_ = sides;
    gl_.FrontFace(item.is_mirrored ? GL_CCW : GL_CW);
    if (is_double) {
        gl_.Disable(GL_CULL_FACE);
    } else {
        gl_.Enable(GL_CULL_FACE);
    }
}

bool DrawPass::may_be_batched(const SceneItem& item) const {
    return batches_ && !item.primitive->may_deform;
}

std::span<const VisibleDraw> DrawPass::batch_of(std::span<const VisibleDraw> draws) const {
    const SceneItem& first = *draws.front().item;
    if (!may_be_batched(first)) return draws.first(1);
    const auto fits = [&](const VisibleDraw& draw) {
        const SceneItem& item = *draw.item;
        // One vertex array and one material: the same shader.
        return item.material == first.material && item.primitive->vertex_array == first.primitive->vertex_array &&
               item.light_set == first.light_set && item.is_mirrored == first.is_mirrored;
    };
    draws = draws.first(std::min(draws.size(), max_batch));
    return {draws.begin(), std::ranges::find_if_not(draws, fits)};
}

void DrawPass::use_vertices(const VisibleDraw& draw) {
    const SceneItem& item = *draw.item;
    const GpuPrimitive& primitive = *item.primitive;
    gl_.BindVertexArray(primitive.vertex_array);
    if (!primitive.may_deform) return;
    const auto fetch_from = [&](GLuint positions, GLintptr position_offset, GLuint normals, GLintptr normal_offset) {
        constexpr GLsizei stride = sizeof(glm::vec3);
        gl_.VertexArrayVertexBuffer(primitive.vertex_array, attribute_position, positions, position_offset, stride);
        if (primitive.source->normals.empty()) return;
        gl_.VertexArrayVertexBuffer(primitive.vertex_array, attribute_normal, normals, normal_offset, stride);
    };
    if (item.deformation >= 0) {
        const Deformation& made = draw.owner->deformed(item, *stream_);
        fetch_from(made.positions.buffer, made.positions.offset, made.normals.buffer, made.normals.offset);
    } else {
        // The same mesh without a skin elsewhere in the file: back to the vertices as they were loaded.
        const GLuint loaded = item.model->vertices.name();
        fetch_from(loaded, primitive.position_offset, loaded, primitive.normal_offset);
    }
}

void DrawPass::write_blocks(std::span<const VisibleDraw> batch) {
    // The block of a shader must be bound whole, however many draws there are.
    constexpr std::size_t bound = max_batch * sizeof(DrawBlock);
    const auto piece = stream_->allocate(batch.size() * sizeof(DrawBlock), bound);
    std::byte* to = piece.data;
    for (const VisibleDraw& draw : batch) {
        std::memcpy(to, &draw.uniforms, sizeof(DrawBlock));
        to += sizeof(DrawBlock);
    }
    gl_.BindBufferRange(GL_UNIFORM_BUFFER, draw_binding, piece.buffer, piece.offset, GLsizeiptr{bound});
}

void DrawPass::draw(std::span<const VisibleDraw> batch, bool both_sides) {
    const SceneItem& first = *batch.front().item;
    const GpuPrimitive& primitive = *first.primitive;
    write_blocks(batch);
    use_sides(first, both_sides);
    use_vertices(batch.front());
    counts_.clear();
    offsets_.clear();
    base_vertices_.clear();
    for (const VisibleDraw& draw : batch) {
        counts_.push_back(draw.range->count);
        offsets_.push_back(reinterpret_cast<const void*>(draw.range->offset));
        base_vertices_.push_back(draw.item->primitive->base_vertex);
        coarse_draws_ += draw.range != &draw.item->primitive->full;
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

GLuint DrawPass::color_program(SceneItem& item) {
    GLuint& program = item.programs[static_cast<std::size_t>(view_.quality)];
    if (program != 0) return program;
    ShaderKey key = item.key;
    key.quality = view_.quality;
    key.batched = may_be_batched(item);
    const LightSet& set = (*view_.light_sets)[item.light_set];
    for (int i = 0; i < set.directional + set.local; ++i) key.has_shadows |= shadow_slot(view_, set.lights[i]) >= 0.0f;
    program = shaders_.program(key);
    return program;
}

void DrawPass::draw_opaque(std::span<const VisibleDraw> draws) {
    while (!draws.empty()) {
        const auto batch = batch_of(draws);
        draws = draws.subspan(batch.size());
        SceneItem& item = *batch.front().item;
        use_program(color_program(item));
        use_material(item);
        if (item.key.lit) use_lights(item.light_set);
        draw(batch);
    }
}

void DrawPass::begin_blending() {
    // Blending is linear light, so here the target encodes; switching it on costs a CPU rasteriser a flush.
    gl_.Enable(GL_FRAMEBUFFER_SRGB);
    gl_.Enable(GL_BLEND);
    gl_.DepthMask(GL_FALSE);
}

void DrawPass::end_blending() {
    gl_.DepthMask(GL_TRUE);
    gl_.Disable(GL_BLEND);
    gl_.Disable(GL_FRAMEBUFFER_SRGB);
}

void DrawPass::draw_sorted(std::vector<VisibleDraw>& draws) {
    // By hand, because stable_sort() allocates.
    for (std::size_t i = 0; i < draws.size(); ++i) draws[i].order = i;
    std::ranges::sort(draws, [](const VisibleDraw& a, const VisibleDraw& b) {
        return a.distance_m != b.distance_m ? a.distance_m > b.distance_m : a.order < b.order;
    });
    draw_opaque(draws);
}

void DrawPass::draw_blended(std::vector<VisibleDraw>& draws) {
    if (draws.empty()) return;
    begin_blending();
    draw_sorted(draws);
    end_blending();
}

void DrawPass::use_depth_program(const SceneItem& item, GLuint (ShaderCache::*program)(DepthKey), bool batched) {
    const bool is_masked = item.key.alpha_mode == AlphaMode::mask;
    use_program((shaders_.*program)({.masked = is_masked,
                                     .uv1 = (item.key.uv_sets & 1) != 0,
                                     .has_color = item.key.has_color,
                                     .textured = item.key.uv_slots[static_cast<int>(TextureUse::base_color)] >= 0,
                                     .batched = batched}));
    if (is_masked) use_material(item);
}

void DrawPass::draw_truth(std::span<const VisibleDraw> draws) {
    while (!draws.empty()) {
        const auto batch = batch_of(draws);
        draws = draws.subspan(batch.size());
        use_depth_program(*batch.front().item, &ShaderCache::truth_program, may_be_batched(*batch.front().item));
        draw(batch);
    }
}

void DrawPass::begin_shadows() {
    begin_instant();
    gl_.DepthFunc(GL_LESS);
    gl_.Enable(GL_DEPTH_CLAMP);
    gl_.Viewport(0, 0, shadow_map_side, shadow_map_side);
}

void DrawPass::end_shadows() {
    gl_.Disable(GL_DEPTH_CLAMP);
}

void DrawPass::draw_shadows(GLuint framebuffer, bool clears, const ShadowView& shadow, SceneItems& items,
                            bool (*casts)(const SceneItem&), double max_error_m, StreamBuffer& stream) {
    stream_ = &stream;
    const float farthest = 1.0f;
    if (clears) gl_.ClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, &farthest);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    for (SceneItem& item : items.items) {
        if (!casts(item)) continue;
        const glm::dmat4 map_from_local = shadow.map_from(item.world_from_local);
        if (!may_be_visible(shadow.frustum, map_from_local, item.bounds.min, item.bounds.max)) continue;
        VisibleDraw visible{.item = &item,
                            .owner = &items,
                            .range = &coarsest_range(item, [&](double error_m) { return error_m <= max_error_m; }),
                            .uniforms = shadow_draw_block(shadow.clip_from_map * map_from_local)};
        use_depth_program(item, &ShaderCache::shadow_program, false);
        draw({&visible, 1}, true);
    }
}

}  // namespace camrig
