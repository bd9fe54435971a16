#pragma once

#include <algorithm>
#include <cstddef>

#include <glm/glm.hpp>

#include "core/render/scene/light_selection.h"
#include "core/render/shadow_plan.h"
#include "core/world/baked/reflection_probes.h"

/// The uniform blocks of shaders/blocks.glsl as C++ (std140: only vec4 and arrays of it, so both layouts agree).
/// Grouped by how often they change, and small: llvmpipe copies each changed block whole.
namespace camrig::render::gl {

inline constexpr unsigned view_binding = 0;
inline constexpr unsigned draw_binding = 1;
inline constexpr unsigned material_binding = 2;
inline constexpr unsigned light_binding = 3;
inline constexpr unsigned shadow_binding = 4;
inline constexpr unsigned surroundings_binding = 5;
inline constexpr unsigned reflection_binding = 6;
/// Of storage blocks.
inline constexpr unsigned body_binding = 0, capsule_binding = 1, reflection_texel_binding = 2, nearness_binding = 3;

struct ViewBlock {
    glm::vec4 projection;
    glm::vec4 depth;
    glm::vec4 up;
    glm::vec4 sky;
    glm::vec4 ground;
    glm::vec4 fog;
    glm::vec4 bodies;
    glm::vec4 light_map;
    glm::vec4 truth_rows[3];
};

struct DrawBlock {
    glm::vec4 position_rows[3];
    glm::vec4 normal_rows[3];
    glm::uvec4 ids;
    glm::vec4 tint;
};

/// Of a draw that takes its light from a place: a block of its own, for only pictures with baked light have them.
struct SurroundingsBlock {
    glm::vec4 rows[3];      ///< of each channel, by the coordinates of the normal, and the mean
    glm::vec4 products[5];  ///< of each of world::products_of(), by channel
};

/// Maximum draws per batch: their blocks fit into the 16 KiB that every device has for a uniform block.
inline constexpr std::size_t max_batch = 128;
static_assert(max_batch * std::max(sizeof(DrawBlock), sizeof(SurroundingsBlock)) <= 16384);

inline constexpr int max_uv_slots = 5;

struct MaterialBlock {
    glm::vec4 base_color;
    glm::vec4 emissive;
    glm::vec4 factors;
    glm::vec4 tint;
    glm::vec4 uv_rows[2 * max_uv_slots];
};

struct DirectionalLightBlock {
    glm::vec4 towards;
    glm::vec4 color;
};

/// Which shadow maps a light of the draw has, the first and how many; after its lights, only where there are any.
struct ShadowSlotBlock {
    glm::vec4 maps;
};

struct ShadowBlock {
    struct Map {
        glm::vec4 rows[4];
        glm::vec4 planes[3];
        glm::vec4 texel;
    };
    Map maps[max_shadow_maps];
};

/// Of a view with baked light (shaders/reflections.glsl).
struct ReflectionBlock {
    glm::vec4 world_rows[3];
    glm::vec4 gain;
    glm::vec4 places[world::max_reflection_probes];
};

struct LocalLightBlock {
    glm::vec4 position;
    glm::vec4 color;
    glm::vec4 direction;
};

}  // namespace camrig::render::gl
