#include "core/render/gl/gpu_model.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <map>
#include <new>

#include "core/render/scene/texture_transform.h"

namespace camrig::render::gl {
namespace {

GLint uniform_alignment(const GlFunctions& gl) {
    GLint alignment = 256;
    gl.GetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &alignment);
    return alignment;
}

GlBuffer immutable_buffer(const GlFunctions& gl, const std::vector<std::byte>& bytes) {
    GlBuffer buffer = make_buffer(gl);
    // Never empty: zero-sized storage is a GL error.
    const std::byte nothing{};
    gl.NamedBufferStorage(buffer.name(), static_cast<GLsizeiptr>(std::max<std::size_t>(bytes.size(), 1)),
                          bytes.empty() ? &nothing : bytes.data(), 0);
    return buffer;
}

template <typename T>
GLintptr append(std::vector<std::byte>& bytes, const std::vector<T>& values) {
    bytes.resize((bytes.size() + 15) / 16 * 16);
    const std::size_t offset = bytes.size();
    bytes.resize(offset + values.size() * sizeof(T));
    if (!values.empty()) std::memcpy(bytes.data() + offset, values.data(), values.size() * sizeof(T));
    return static_cast<GLintptr>(offset);
}

GlTexture upload_image(const GlFunctions& gl, const world::Image& image, bool is_color) {
    GlTexture texture = make_texture_2d(gl);
    const auto longest = static_cast<unsigned>(std::max(image.size.width, image.size.height));
    gl.TextureStorage2D(texture.name(), std::bit_width(longest), is_color ? GL_SRGB8_ALPHA8 : GL_RGBA8,
                        image.size.width, image.size.height);
    gl.TextureSubImage2D(texture.name(), 0, 0, 0, image.size.width, image.size.height, GL_RGBA, GL_UNSIGNED_BYTE,
                         image.rgba.data());
    gl.GenerateTextureMipmap(texture.name());
    return texture;
}

/// Uploads images on first use; one image may be needed both as colour (sRGB) and as data.
class TextureUploader {
public:
    TextureUploader(const GlFunctions& gl, SamplerCache& samplers, const world::Model& model, GpuModel& gpu)
        : gl_(gl), samplers_(samplers), model_(model), gpu_(gpu) {}

    GpuTexture upload(const world::TextureRef& ref, TextureUse use) {
        const world::Texture& texture = model_.textures[static_cast<std::size_t>(ref.texture)];
        const bool is_color = use == TextureUse::base_color || use == TextureUse::emissive;
        const auto [entry, is_new] = uploaded_.try_emplace({texture.image, is_color}, 0u);
        if (is_new) {
            const world::Image& image = model_.images[static_cast<std::size_t>(texture.image)];
            gpu_.textures.push_back(upload_image(gl_, image, is_color));
            entry->second = gpu_.textures.back().name();
        }
        GpuTexture result{.texture = entry->second};
        for (const world::Quality quality : {world::Quality::fast, world::Quality::simple, world::Quality::beautiful}) {
            result.samplers[static_cast<std::size_t>(quality)] = samplers_.sampler(texture.sampler, quality);
        }
        return result;
    }

private:
    const GlFunctions& gl_;
    SamplerCache& samplers_;
    const world::Model& model_;
    GpuModel& gpu_;
    std::map<std::pair<int, bool>, GLuint> uploaded_;
};

std::array<const world::TextureRef*, texture_use_count> textures_of(const world::Material& material) {
    return {&material.base_color_texture, &material.emissive_texture, &material.occlusion_texture,
            &material.normal_texture, &material.metallic_roughness_texture};
}

bool same_coordinates(const world::TextureRef& a, const world::TextureRef& b) {
    return a.texcoord == b.texcoord && a.offset == b.offset && a.scale == b.scale && a.rotation == b.rotation;
}

/// Texture coordinates of a material: uses that agree in set and transform share a slot.
struct UvSlots {
    std::array<std::int8_t, texture_use_count> slot_of_use{-1, -1, -1, -1, -1};
    std::array<const world::TextureRef*, max_uv_slots> refs{};
    int count = 0;
};

UvSlots assign_uv_slots(const world::Material& material) {
    UvSlots slots;
    const auto refs = textures_of(material);
    for (std::size_t use = 0; use < refs.size(); ++use) {
        if (refs[use]->texture < 0) continue;
        int slot = 0;
        while (slot < slots.count && !same_coordinates(*slots.refs[slot], *refs[use])) ++slot;
        if (slot == slots.count) slots.refs[slots.count++] = refs[use];
        slots.slot_of_use[use] = static_cast<std::int8_t>(slot);
    }
    return slots;
}

MaterialBlock block_of(const world::Material& material, const UvSlots& slots) {
    MaterialBlock block{};
    block.base_color = material.base_color;
    const bool is_blended = material.alpha_mode == world::AlphaMode::blend;
    block.emissive = glm::vec4(material.emissive, is_blended ? material.transmission : material.alpha_cutoff);
    block.factors =
        glm::vec4(material.metallic, material.roughness, material.normal_scale, material.occlusion_strength);
    block.tint = glm::vec4(material.tint, 0.0f);
    for (int i = 0; i < slots.count; ++i) {
        const scene::TextureTransform transform = scene::transform_of(*slots.refs[i]);
        block.uv_rows[2 * i] = glm::vec4(transform.u, 0.0f);
        block.uv_rows[2 * i + 1] = glm::vec4(transform.v, 0.0f);
    }
    return block;
}

ShaderKey key_of(const world::Material& material, const UvSlots& slots, const world::Primitive& primitive) {
    ShaderKey key;
    key.alpha_mode = material.alpha_mode;
    key.lit = !material.unlit && !primitive.normals.empty();
    key.double_sided = material.double_sided;
    key.has_color = !primitive.colors.empty();
    key.has_tangent = !primitive.tangents.empty();
    const auto refs = textures_of(material);
    for (std::size_t use = 0; use < refs.size(); ++use) {
        const int slot = slots.slot_of_use[use];
        if (slot < 0 || primitive.texcoords[refs[use]->texcoord].empty()) continue;
        key.uv_slots[use] = static_cast<std::int8_t>(slot);
    }
    for (int i = 0; i < slots.count; ++i) {
        if (slots.refs[i]->texcoord == 1) key.uv_sets |= static_cast<std::uint8_t>(1 << i);
    }
    return key;
}

GLenum mode_of(world::Topology topology) {
    switch (topology) {
        case world::Topology::points:
            return GL_POINTS;
        case world::Topology::lines:
            return GL_LINES;
        case world::Topology::triangles:
            return GL_TRIANGLES;
    }
    return GL_TRIANGLES;
}

/// Components of each VertexAttribute.
constexpr std::array<GLint, attribute_count> components_of{3, 3, 4, 2, 2, 4, 2};

/// Collects the vertices and indices of all primitives, by the vertex array they will be in.
class GeometryUploader {
public:
    void add(const scene::PreparedPrimitive& prepared, GpuPrimitive& gpu) {
        const world::Primitive& primitive = *prepared.source;
        const bool is_narrow = gpu.layout.has_narrow_indices;
        gpu.index_type = is_narrow ? GL_UNSIGNED_SHORT : GL_UNSIGNED_INT;
        gpu.levels.push_back(range(primitive.indices, is_narrow));
        for (const scene::MeshLevel& level : prepared.coarser) {
            std::vector<std::uint32_t> list;
            for (std::size_t i = 0; i < level.triangles[0].size(); ++i)
                for (const auto& corners : level.triangles) list.push_back(corners[i]);
            gpu.levels.push_back(range(list, is_narrow));
        }
        Group& group = group_of(gpu);
        gpu.base_vertex = group.vertex_count;
        group.vertex_count += static_cast<GLint>(primitive.positions.size());
        const auto put = [&]<typename T>(VertexAttribute attribute, const std::vector<T>& values) {
            CHECK(values.empty() || values.size() == primitive.positions.size());
            std::vector<float>& to = group.values[attribute];
            for (const T& value : values) to.insert(to.end(), &value[0], &value[0] + T::length());
        };
        put(attribute_position, primitive.positions);
        put(attribute_normal, primitive.normals);
        put(attribute_tangent, primitive.tangents);
        put(attribute_uv0, primitive.texcoords[0]);
        put(attribute_uv1, primitive.texcoords[1]);
        put(attribute_color, primitive.colors);
        put(attribute_light, primitive.light_coordinates);
        group.members.push_back(&gpu);
    }

    /// After the last add(): fills what the model and its primitives have of vertices.
    void upload(const GlFunctions& gl, GpuModel& gpu) {
        std::vector<std::byte> bytes;
        for (Group& group : groups_) {
            for (std::size_t i = 0; i < attribute_count; ++i) group.offsets[i] = append(bytes, group.values[i]);
        }
        gpu.vertices = immutable_buffer(gl, bytes);
        gpu.indices = immutable_buffer(gl, indices_);
        for (const Group& group : groups_) {
            const GlVertexArray& array =
                gpu.vertex_arrays.emplace_back(make_layout(gl, group, gpu.vertices.name(), gpu.indices.name()));
            for (GpuPrimitive* member : group.members) {
                member->vertex_array = array.name();
                member->position_offset = group.offsets[attribute_position];
                member->normal_offset = group.offsets[attribute_normal];
            }
        }
    }

private:
    struct Group {
        std::array<std::vector<float>, attribute_count> values;
        std::array<GLintptr, attribute_count> offsets{};  ///< of the values in the buffer
        GLint vertex_count = 0;
        std::vector<GpuPrimitive*> members;
    };

    Group& group_of(const GpuPrimitive& gpu) {
        const auto fits = [&](const Group& group) {
            const GpuPrimitive& other = *group.members.front();
            return !gpu.may_deform && !other.may_deform && gpu.layout == other.layout &&
                   gpu.has_light_coordinates == other.has_light_coordinates;
        };
        const auto found = std::ranges::find_if(groups_, fits);
        return found != groups_.end() ? *found : groups_.emplace_back();
    }

    IndexRange range(const std::vector<std::uint32_t>& list, bool is_narrow) {
        const auto count = static_cast<GLsizei>(list.size());
        if (!is_narrow) return {.offset = append(indices_, list), .count = count};
        const std::vector<std::uint16_t> narrow(list.begin(), list.end());
        return {.offset = append(indices_, narrow), .count = count};
    }

    static GlVertexArray make_layout(const GlFunctions& gl, const Group& group, GLuint vertices, GLuint indices) {
        GlVertexArray array = make_vertex_array(gl);
        gl.VertexArrayElementBuffer(array.name(), indices);
        for (GLuint attribute = 0; attribute < attribute_count; ++attribute) {
            if (group.values[attribute].empty()) continue;
            const GLint components = components_of[attribute];
            gl.EnableVertexArrayAttrib(array.name(), attribute);
            gl.VertexArrayAttribFormat(array.name(), attribute, components, GL_FLOAT, GL_FALSE, 0);
            gl.VertexArrayAttribBinding(array.name(), attribute, attribute);
            gl.VertexArrayVertexBuffer(array.name(), attribute, vertices, group.offsets[attribute],
                                       components * static_cast<GLsizei>(sizeof(float)));
        }
        return array;
    }

    std::vector<Group> groups_;
    std::vector<std::byte> indices_;
};

}  // namespace

GpuModel upload_model(const GlFunctions& gl, SamplerCache& samplers, const world::Model& model,
                      const scene::PreparedModel& prepared) {
    GpuModel gpu;
    std::vector<world::Material> materials = model.materials;
    materials.emplace_back();  // the glTF default

    TextureUploader textures(gl, samplers, model, gpu);
    std::vector<UvSlots> slots;
    std::vector<std::byte> uniforms;
    const auto alignment = static_cast<std::size_t>(uniform_alignment(gl));
    for (const world::Material& material : materials) {
        slots.push_back(assign_uv_slots(material));
        GpuMaterial entry{.alpha_mode = material.alpha_mode, .double_sided = material.double_sided};
        const auto refs = textures_of(material);
        for (int use = 0; use < texture_use_count; ++use) {
            if (refs[use]->texture >= 0)
                entry.textures[use] = textures.upload(*refs[use], static_cast<TextureUse>(use));
        }
        uniforms.resize((uniforms.size() + alignment - 1) / alignment * alignment);
        entry.block_offset = append(uniforms, std::vector{block_of(material, slots.back())});
        gpu.materials.push_back(entry);
    }
    gpu.uniforms = immutable_buffer(gl, uniforms);

    GeometryUploader geometry;
    gpu.primitives.resize(prepared.primitives.size());
    for (const scene::PreparedSurface& surface : prepared.surfaces)
        if (surface.is_deformed) gpu.primitives[surface.primitive->number].may_deform = true;
    for (const scene::PreparedPrimitive& primitive : prepared.primitives) {
        GpuPrimitive& entry = gpu.primitives[primitive.number];
        const int number = primitive.source->material;
        const auto material = number < 0 ? materials.size() - 1 : static_cast<std::size_t>(number);
        entry.material = static_cast<int>(material);
        entry.mode = mode_of(primitive.source->topology);
        entry.key = key_of(materials[material], slots[material], *primitive.source);
        entry.layout = scene::vertex_layout(*primitive.source);
        entry.has_light_coordinates = !primitive.source->light_coordinates.empty();
        geometry.add(primitive, entry);
    }
    geometry.upload(gl, gpu);
    if (is_out_of_memory(gl)) throw std::bad_alloc();
    return gpu;
}

}  // namespace camrig::render::gl
