#pragma once

#include <array>
#include <vector>

#include "core/render/gl/gl_objects.h"
#include "core/render/gl/sampler_cache.h"
#include "core/render/gl/shader_key.h"
#include "core/render/scene/prepared_model.h"
#include "core/world/model.h"

namespace camrig::render::gl {

/// Vertex attribute locations and the vertex buffer bindings of the same number.
enum VertexAttribute : GLuint {
    attribute_position,
    attribute_normal,
    attribute_tangent,
    attribute_uv0,
    attribute_uv1,
    attribute_color,
    attribute_light,  ///< world::Primitive::light_coordinates
    attribute_count
};

/// A piece of GpuModel::indices.
struct IndexRange {
    GLintptr offset = 0;
    GLsizei count = 0;
};

struct GpuPrimitive {
    GLuint vertex_array = 0;  ///< one of GpuModel::vertex_arrays
    GLint base_vertex = 0;    ///< its first vertex there
    bool may_deform = false;  ///< then the vertex array is its own
    GLenum mode = GL_TRIANGLES;
    GLenum index_type = GL_UNSIGNED_INT;
    std::vector<IndexRange> levels;  ///< of detail: the full mesh, then those of PreparedPrimitive::coarser
    GLintptr position_offset = 0;    ///< in GpuModel::vertices; of those that may deform
    GLintptr normal_offset = 0;
    int material = 0;  ///< into GpuModel::materials
    ShaderKey key;     ///< material and vertex part; quality and lights are filled per draw
    scene::VertexLayout layout;
    bool has_light_coordinates = false;  ///< not in the layout: surfaces keep their order without baked light
};

struct GpuTexture {
    GLuint texture = 0;
    std::array<GLuint, 3> samplers{};  ///< per Quality
};

struct GpuMaterial {
    GLintptr block_offset = 0;  ///< MaterialBlock in GpuModel::uniforms
    std::array<GpuTexture, texture_use_count> textures{};
    world::AlphaMode alpha_mode = world::AlphaMode::opaque;
    bool double_sided = false;
};

/// A Model on the device: uploaded once, drawn by every camera.
struct GpuModel {
    GlBuffer vertices;
    GlBuffer indices;
    GlBuffer uniforms;
    std::vector<GlVertexArray> vertex_arrays;  ///< rigid primitives of one layout share one
    std::vector<GlTexture> textures;
    std::vector<GpuMaterial> materials;    ///< the glTF default material is the last
    std::vector<GpuPrimitive> primitives;  ///< as of PreparedModel
};

/// Throws std::bad_alloc when the device has no memory left (GlRenderer::draw catches it).
GpuModel upload_model(const GlFunctions& gl, SamplerCache& samplers, const world::Model& model,
                      const scene::PreparedModel& prepared);

}  // namespace camrig::render::gl
