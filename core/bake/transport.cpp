#include "core/bake/transport.h"

#include "core/bake/ray_sampling.h"
#include "core/bake/reflections.h"
#include "core/bake/texel_light.h"

namespace camrig::bake {
namespace {

/// Beside the rays to all sides, so many to surfaces that are lamps.
constexpr int lamp_rays_of_probe = 256;

/// What arrives at probes in the open, and what mirrors see from there, once the texels have their light.
class ProbeLight {
public:
    ProbeLight(const RayScene& scene, const TexelLight& light, std::span<const Source> sources, const world::Scene& of,
               const world::ProbeGrid& grid, const TransportOptions& options, BakeTeam& team)
        : scene_(scene), light_(light), sources_(sources), of_(of), grid_(grid), options_(options), team_(team) {}

    void find_probes(Transport& to, double share);
    /// After find_probes(), which knows the open places.
    void find_reflections(Transport& to, double share);

private:
    const RayScene& scene_;
    const TexelLight& light_;
    std::span<const Source> sources_;
    const world::Scene& of_;
    const world::ProbeGrid& grid_;
    const TransportOptions& options_;
    BakeTeam& team_;
};

void ProbeLight::find_probes(Transport& to, double share) {
    const std::size_t count = grid_.size();
    to.probes.assign(sources_.size(), std::vector<world::LightProbe>(count));
    to.is_open.assign(count, 0);
    team_.run(count, share, BakeTeam::usual_block, [&](std::size_t number) {
        const auto x = number % static_cast<std::size_t>(grid_.count.x);
        const auto y = number / static_cast<std::size_t>(grid_.count.x) % static_cast<std::size_t>(grid_.count.y);
        const auto z = number / static_cast<std::size_t>(grid_.count.x) / static_cast<std::size_t>(grid_.count.y);
        const glm::vec3 from(grid_.first + grid_.spacing_m * glm::dvec3(x, y, z));
        const glm::vec2 shift = shift_of(7, number);
        int inside = 0;
        for (int i = 0; i < options_.probe_rays; ++i) {
            const glm::vec3 along = to_all_sides(spread_point(i, shift));
            Gathered sum{};
            inside += light_.look({from, along}, sum).is_inside;
            for (std::size_t layer = 0; layer < sources_.size(); ++layer)
                to.probes[layer][number].add(sum[layer], along);
        }
        const float part = 1.0f / static_cast<float>(options_.probe_rays);
        to.is_open[number] = static_cast<float>(inside) * part < 0.1f;
        for (auto& layer : to.probes) layer[number] = layer[number].scaled(glm::vec3(part));
        // A lamp, by how it lights what faces it.
        const auto add = [&](std::size_t layer, const glm::vec3& arriving, const glm::vec3& towards) {
            to.probes[layer][number].add(0.25f * arriving, towards);
        };
        // Lamps are points, or as small: no ray meets them.
        for (std::size_t layer = 0; layer < sources_.size(); ++layer) {
            for (const std::size_t lamp : sources_[layer].lamps) {
                const world::Light& light = of_.lights[lamp];
                if (light.type == world::LightType::directional) continue;
                const glm::vec3 way = glm::vec3(light.position) - from;
                const float length = glm::length(way);
                if (length < 1e-3f) continue;
                const MapPlace place{from, way / length, way / length, {}};
                add(layer, light_.direct(place, lamp), place.side);
            }
        }
        static thread_local std::vector<float> lamps;
        if (!light_.area_lamps().empty()) light_.area_lamps().weigh(from, glm::vec3(0.0f), false, lamps);
        for (int i = 0; !light_.area_lamps().empty() && i < lamp_rays_of_probe; ++i) {
            const auto lamp = light_.area_lamps().sample(lamps, from, spread_point(i, shift));
            if (!lamp) continue;
            const glm::vec3 open = scene_.open_share({from, lamp->towards, lamp->distance - lift_m});
            add(light_.glow_layer(), lamp->light * open / static_cast<float>(lamp_rays_of_probe), lamp->towards);
        }
    });
}

void ProbeLight::find_reflections(Transport& to, double share) {
    to.reflection_probes.places = reflection_places(scene_, of_, grid_, to.is_open, options_.most_reflections);
    const auto& places = to.reflection_probes.places;
    std::vector<ReflectionView> views(places.size());
    const auto look_along = [this](const Ray& ray, std::span<glm::vec3> by_layer) {
        return light_.look(ray, by_layer, TexelLight::AreaLampsCount::yes).distance;
    };
    team_.run(places.size(), share, 1, [&](std::size_t i) {
        views[i] = reflection_view(places[i], world::levels_of_probe(i), sources_.size(), look_along);
    });
    to.reflections.assign(sources_.size(), {});
    for (const ReflectionView& view : views) {
        to.reflection_probes.nearness.insert(to.reflection_probes.nearness.end(), view.nearness.begin(),
                                             view.nearness.end());
        for (std::size_t layer = 0; layer < view.texels.size(); ++layer)
            to.reflections[layer].insert(to.reflections[layer].end(), view.texels[layer].begin(),
                                         view.texels[layer].end());
    }
}

}  // namespace

Transport find_transport(const RayScene& scene, const LightMap& map, std::span<const Source> sources,
                         const world::Scene& of, const world::ProbeGrid& grid, const TransportOptions& options) {
    Transport made;
    BakeTeam team(options.threads, options.progress);
    TexelLight light(scene, map, sources, of.lights, options, team);
    if (!light.solve()) return made;
    ProbeLight probes(scene, light, sources, of, grid, options, team);
    probes.find_probes(made, 0.05);
    probes.find_reflections(made, 0.01);
    made.texels = light.take_texels();
    made.is_whole = !team.is_ended();
    return made;
}

}  // namespace camrig::bake
