#include "core/bake/texture_colors.h"

#include <algorithm>
#include <cmath>

#include "core/frame/srgb.h"
#include "core/render/scene/texture_transform.h"

namespace camrig::bake {
namespace {

int texel_of(float at, int size, world::Wrap wrap) {
    if (!std::isfinite(at)) return 0;
    if (wrap == world::Wrap::repeat) {
        at -= std::floor(at);
    } else if (wrap == world::Wrap::mirrored_repeat) {
        at -= 2.0f * std::floor(at * 0.5f);
        if (at > 1.0f) at = 2.0f - at;
    }
    at = std::clamp(at, 0.0f, 1.0f);
    return std::min(static_cast<int>(at * static_cast<float>(size)), size - 1);
}

}  // namespace

TextureColors::TextureColors() {
    for (int code = 0; code < 256; ++code) linear_[code] = static_cast<float>(frame::linear_of_srgb(code / 255.0));
}

glm::vec4 TextureColors::of(const world::Model& model, const world::TextureRef& ref, const world::Primitive& primitive,
                            const glm::uvec3& corners, const glm::vec3& shares) const {
    if (ref.texture < 0 || primitive.texcoords[ref.texcoord].empty()) return glm::vec4(1.0f);
    const auto& set = primitive.texcoords[ref.texcoord];
    const glm::vec2 at = render::scene::transform_of(ref)(set[corners.x] * shares.x + set[corners.y] * shares.y +
                                                          set[corners.z] * shares.z);
    const world::Texture& texture = model.textures[static_cast<std::size_t>(ref.texture)];
    const world::Image& image = model.images[static_cast<std::size_t>(texture.image)];
    const auto x = static_cast<std::size_t>(texel_of(at.x, image.size.width, texture.sampler.wrap_s));
    const auto y = static_cast<std::size_t>(texel_of(at.y, image.size.height, texture.sampler.wrap_t));
    const std::uint8_t* const code = image.rgba.data() + 4 * (y * static_cast<std::size_t>(image.size.width) + x);
    return {linear_[code[0]], linear_[code[1]], linear_[code[2]], static_cast<float>(code[3]) / 255.0f};
}

}  // namespace camrig::bake
