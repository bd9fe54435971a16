#include "core/render/gl/shader_key.h"

#include <algorithm>

#include "core/render/scene/body_capsules.h"
#include "core/render/scene/reflections.h"
#include "core/render/surface_tables.h"

namespace camrig::render::gl {
namespace {

int round_up(int count, std::initializer_list<int> steps) {
    return *std::ranges::find_if(steps, [count](int step) { return step >= count; });
}

/// Of shaders/reflections.glsl.
std::string reflection_defines() {
    const auto list = [](const auto& value) {
        std::string made;
        for (std::size_t i = 0; i < world::reflection_levels.size(); ++i)
            made += (made.empty() ? "" : ", ") + std::to_string(value(i));
        return made;
    };
    const auto& levels = world::reflection_levels;
    return "#define MAX_REFLECTION_PROBES " + std::to_string(world::max_reflection_probes) +
           "\n#define MOST_MIRROR_PROBES " + std::to_string(world::most_mirror_probes) + "\n#define MIRROR_LEVEL " +
           std::to_string(world::mirror_level) + "\n#define TEXELS_OF_MIRROR " +
           std::to_string(scene::ReflectionMaps::texels_of_mirror) + "\n#define REFLECTION_STARTS " +
           list([](std::size_t i) { return scene::ReflectionMaps::level_starts[i]; }) + "\n#define REFLECTION_SIDES " +
           list([&](std::size_t i) { return levels[i].side; }) + "\n#define REFLECTION_ROUGHNESS " +
           list([&](std::size_t i) { return levels[i].roughness; }) + "\n#define NEARNESS_SIDE " +
           std::to_string(world::nearness_side) + "\n";
}

}  // namespace

int rounded_directional(int count) {
    return round_up(count, {0, 1, 2, 4, scene::max_lights_per_draw});
}
int rounded_local(int count) {
    return round_up(count, {0, 1, 2, 3, 4, 6, scene::max_lights_per_draw});
}

ShaderKey simplified(ShaderKey key) {
    auto& slots = key.uv_slots;
    const auto drop = [&slots](TextureUse use) { slots[static_cast<int>(use)] = -1; };
    if (!key.lit) {
        key.directional_lights = key.local_lights = 0;
        drop(TextureUse::emissive);
    }
    if (!key.lit) drop(TextureUse::occlusion);
    if (!key.lit || key.quality != world::Quality::beautiful) {
        drop(TextureUse::normal);
        drop(TextureUse::metallic_roughness);
    }
    if (!key.lit || key.quality != world::Quality::beautiful) key.light_around = LightAround::hemisphere;
    // Lamps are in baked light, and what hides light is in the map.
    if (key.light_around != LightAround::hemisphere) key.local_lights = 0;
    if (key.light_around == LightAround::map) drop(TextureUse::occlusion);
    if (slots[static_cast<int>(TextureUse::normal)] < 0) key.has_tangent = false;
    if (!key.lit) key.double_sided = false;
    if (!key.lit || key.quality != world::Quality::beautiful) key.has_shadows = false;
    key.directional_lights = static_cast<std::uint8_t>(rounded_directional(key.directional_lights));
    key.local_lights = static_cast<std::uint8_t>(rounded_local(key.local_lights));
    const int used = *std::ranges::max_element(slots) + 1;
    key.uv_sets &= static_cast<std::uint8_t>((1 << used) - 1);
    return key;
}

std::string batch_defines(bool batched) {
    if (!batched) return {};
    return "#extension GL_ARB_shader_draw_parameters : require\n#define BATCH_SIZE " + std::to_string(max_batch) + "\n";
}

std::string defines_of(const ShaderKey& key) {
    static constexpr std::array<const char*, texture_use_count> names{"BASE_UV", "EMISSIVE_UV", "OCCLUSION_UV",
                                                                      "NORMAL_UV", "METALLIC_ROUGHNESS_UV"};
    std::string text = batch_defines(key.batched);
    const auto define = [&text](const std::string& line) { text += "#define " + line + "\n"; };
    const bool beautiful = key.quality == world::Quality::beautiful;
    const bool per_pixel = key.lit && key.quality != world::Quality::fast;

    const int uv_count = *std::ranges::max_element(key.uv_slots) + 1;
    define("UV_COUNT " + std::to_string(uv_count));
    for (int i = 0; i < uv_count; ++i) {
        define("UV" + std::to_string(i) + ((key.uv_sets >> i & 1) != 0 ? " in_uv1" : " in_uv0"));
    }
    for (int i = 0; i < texture_use_count; ++i) {
        if (key.uv_slots[i] >= 0) define(std::string(names[i]) + " " + std::to_string(key.uv_slots[i]));
    }
    define("DIRECTIONAL_LIGHTS " + std::to_string(key.directional_lights));
    define("LOCAL_LIGHTS " + std::to_string(key.local_lights));
    if (key.has_color) define("HAS_COLOR");
    if (key.has_tangent) define("HAS_TANGENT");
    if (!key.lit) define("UNLIT");
    if (key.double_sided) define("DOUBLE_SIDED");
    if (key.alpha_mode == world::AlphaMode::mask) define("ALPHA_MASK");
    if (key.alpha_mode == world::AlphaMode::blend) define("BLEND");
    if (key.lit && !per_pixel) define("VERTEX_LIGHT");
    if (per_pixel) define("PIXEL_NORMAL");
    if (key.has_fog || (per_pixel && (beautiful || key.local_lights > 0))) define("PIXEL_POSITION");
    if (key.has_fog) define("FOG");
    if (per_pixel && beautiful) define("GGX");
    if (per_pixel && beautiful) define("CONTACT_REACH " + std::to_string(scene::contact_reach_m));
    if (per_pixel && beautiful) define("TABLE_SIDE " + std::to_string(table_side) + ".0");
    if (key.light_around != LightAround::hemisphere) text += "#define BAKED\n" + reflection_defines();
    if (key.light_around == LightAround::map) define("LIGHT_MAP");
    if (key.light_around == LightAround::surroundings) define("SURROUNDINGS");
    if (key.has_shadows) {
        define("SHADOWS");
        define("MAX_SHADOWS " + std::to_string(max_shadow_maps));
        define("SHADOW_BIAS_TEXELS " + std::to_string(shadow_bias_texels));
        define("LEAST_SHADOW_COSINE " + std::to_string(least_shadow_cosine));
    }
    return text;
}

}  // namespace camrig::render::gl
