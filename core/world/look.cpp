#include "core/world/look.h"

#include <algorithm>

#include "core/base/digest.h"
#include "core/base/random.h"

namespace camrig::world {
namespace {

double number_for(std::uint64_t variant, const char* of, const std::string& name) {
    Digest stream;
    stream.add(of);
    stream.add(std::string_view(name));
    return random_unit(variant, stream.value(), 0);
}

glm::vec3 tint_to(const glm::vec3& color, const Material& material) {
    return color / glm::vec3(material.base_color);
}

}  // namespace

Look look_of(const Model& model, std::optional<std::uint64_t> variant) {
    Look look;
    bool is_plain = true;
    for (const Material& material : model.materials) {
        const MaterialVariants& from = material.variants;
        MaterialLook& made = look.emplace_back();
        made.is_hidden = !from.is_shown;
        if (variant) {
            if (!from.choice.empty()) {
                const double chosen = number_for(*variant, "choice", from.choice);
                made.is_hidden = chosen < from.from || chosen >= from.to;
            }
            if (!from.colors.empty()) {
                const double chosen = number_for(*variant, "dye", from.dye.empty() ? material.name : from.dye);
                const auto count = from.colors.size();
                made.tint = tint_to(
                    from.colors[std::min(static_cast<std::size_t>(chosen * static_cast<double>(count)), count - 1)],
                    material);
            }
        }
        is_plain &= !made.is_hidden && made.tint == glm::vec3(1.0f);
    }
    if (is_plain) look.clear();
    return look;
}

}  // namespace camrig::world
