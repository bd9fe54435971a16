#include "core/render/software/baked_picture.h"

#include <algorithm>
#include <iterator>

#include "core/render/scene/light_sum.h"

namespace camrig::render::software {
namespace {

constexpr std::size_t most_states = 4;

SampledTexture use_of(const BakedPicture& picture, const world::Primitive& primitive) {
    SampledTexture use;
    use.image = &picture.map;
    use.sampler = {.wrap_s = world::Wrap::clamp_to_edge, .wrap_t = world::Wrap::clamp_to_edge, .mipmaps = false};
    const glm::vec2 scale = 1.0f / glm::vec2(picture.light->size.width, picture.light->size.height);
    use.coordinates.reserve(primitive.light_coordinates.size());
    for (const glm::vec2& at : primitive.light_coordinates) use.coordinates.push_back(at * scale);
    return use;
}

std::shared_ptr<BakedPicture> summed(const world::BakedLightRef& of, std::vector<glm::vec3> weights,
                                     std::shared_ptr<const scene::ProbeSights> sights) {
    auto made = std::make_shared<BakedPicture>();
    made->light = of;
    const world::BakedLight& light = *of;
    scene::LightMapSum sum = scene::sum_map(light, weights);
    made->map.levels = {{light.size.width, light.size.height, 0}};
    made->map.texels = std::move(sum.texels);
    made->scale = sum.scale;
    made->probes = scene::sum_probes(light, weights);
    made->reflections = scene::sum_reflections(light, weights);
    made->sights = std::move(sights);
    made->weights = std::move(weights);
    return made;
}

}  // namespace

std::shared_ptr<const BakedPicture> BakedPictures::of(const world::StaticSet& statics, double lamps_hz) {
    const std::lock_guard lock(mutex_);
    if (statics.baked_light == nullptr) {
        last_.clear();
        return nullptr;
    }
    if (!last_.empty() && last_.begin()->second->light != statics.baked_light) last_.clear();
    if (lamps_hz != 0.0 && !last_.contains(lamps_hz))  // of frequencies that lamps had before
        std::erase_if(last_, [&](const auto& one) {
            return one.first != 0.0 && std::ranges::none_of(statics.lights, [&](const world::Light& light) {
                       return light.flicker_hz == one.first;
                   });
        });
    // A frequency more takes the place of another: each has a map of its own.
    if (!last_.contains(lamps_hz) && last_.size() >= most_states) last_.erase(std::prev(last_.end())->first);
    const auto found = last_.find(lamps_hz);
    const std::shared_ptr<const BakedPicture> last = found == last_.end() ? nullptr : found->second;
    std::vector<glm::vec3> weights = scene::layer_weights(statics, lamps_hz);
    const bool is_same_light = last != nullptr && last->weights == weights;
    const auto has_model = [&](const world::Instance& object) {
        return last->models.contains(object.info->model.get());
    };
    if (is_same_light && std::ranges::all_of(statics.objects, has_model)) return last;
    // Another object may be there, or one that was hidden.
    std::shared_ptr<const scene::ProbeSights> sights;
    for (const auto& [hz, picture] : last_) sights = picture->sights;
    if (sights == nullptr)
        sights = std::make_shared<scene::ProbeSights>(scene::sights_of(statics.baked_light->reflection_probes));
    const auto made = is_same_light ? std::make_shared<BakedPicture>(*last)
                                    : summed(statics.baked_light, std::move(weights), std::move(sights));
    made->of_primitives.clear();
    made->models.clear();
    for (const world::Instance& object : statics.objects) {
        if (!made->models.insert(object.info->model.get()).second) continue;
        for (const world::Mesh& mesh : object.info->model->meshes)
            for (const world::Primitive& primitive : mesh.primitives)
                if (!primitive.light_coordinates.empty())
                    made->of_primitives.try_emplace(&primitive, use_of(*made, primitive));
    }
    last_.insert_or_assign(lamps_hz, made);
    return made;
}

}  // namespace camrig::render::software
