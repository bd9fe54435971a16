#include "core/bake/transport.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "core/bake/area_lamps.h"
#include "core/bake/ray_sampling.h"
#include "core/bake/reflections.h"
#include "core/render/scene/view_lights.h"
#include "core/render/software/lambert.h"
#include "core/render/software/thread_team.h"

namespace camrig::bake {
namespace {

using world::LightSource;

/// Rays begin so far before their surface.
constexpr float lift_m = 5e-4f;
/// A texel's places have so many rays each. A place from which more of them meet the inside of something is within
/// that, or under it, and counts for nothing.
constexpr int rays_of_place = 16, most_insides = 2;
constexpr std::size_t block_of_texels = 2048;
/// Beside them, so many to lamps.
constexpr int lamp_rays_of_place = 4, lamp_rays_of_probe = 256;
constexpr std::size_t max_layers = 64;
/// A bounce that adds no more than this to any layer is the last.
constexpr double settled_share = 0.003;

using Gathered = std::array<glm::vec3, max_layers>;

class Solver {
public:
    Solver(const RayScene& scene, const LightMap& map, std::span<const Source> sources, const world::Scene& of,
           const world::ProbeGrid& grid, const TransportOptions& options)
        : scene_(scene),
          map_(map),
          sources_(sources),
          of_(of),
          lights_(of.lights),
          grid_(grid),
          options_(options),
          team_(std::max(1, options.threads)),
          area_lamps_(scene) {
        const auto glow = std::ranges::find(sources, LightSource::glow, &Source::kind);
        glow_layer_ = static_cast<std::size_t>(glow - sources.begin());
        for (world::Light light : lights_) {
            light.color = glm::vec3(1.0f);
            light.intensity = 1.0f;
            of_strength_1_.push_back(render::scene::light_in_view(light, {}, 1.0f));
        }
    }

    Transport solve();

private:
    bool run(std::size_t count, double share, std::size_t block, const std::function<void(std::size_t)>& work);
    void find_direct();
    glm::vec3 direct(const MapPlace& place, std::size_t lamp, bool both_sides) const;
    /// Of surfaces that are lamps, by so many rays from the i-th on.
    glm::vec3 of_area_lamps(const MapPlace& place, bool both_sides, const std::vector<float>& sums, int first, int rays,
                            const glm::vec2& shift) const;
    /// What comes along a ray, added by layer. Rays that are sent to surfaces that are lamps count those.
    enum class AreaLampsCount : bool { no, yes };
    struct Met {
        bool is_inside = false;  ///< of something
        float distance = std::numeric_limits<float>::infinity();
    };
    Met look(const Ray& ray, std::span<glm::vec3> sum, AreaLampsCount lamps = AreaLampsCount::no) const;
    /// False: all of the texel is inside of something.
    bool gather(const MapTexel& texel, int rays, std::uint64_t stream, Gathered& sum) const;
    bool gather_all(int rays, std::uint64_t stream, double share);
    void find_radiance();
    double total(std::size_t layer) const;
    bool bounce_all(double share);
    void mend_insides();
    void smooth();
    void find_probes(Transport& to, double share);
    void find_reflections(Transport& to, double share);
    bool is_two_sided(const MapTexel& texel) const { return scene_.surfaces()[texel.surface].material->double_sided; }

    const RayScene& scene_;
    const LightMap& map_;
    std::span<const Source> sources_;
    const world::Scene& of_;
    std::span<const world::Light> lights_;
    std::vector<render::scene::LightInView> of_strength_1_;  ///< the same, where they are in the world
    const world::ProbeGrid& grid_;
    const TransportOptions& options_;
    render::software::ThreadTeam team_;
    AreaLamps area_lamps_;
    std::size_t glow_layer_ = 0;  ///< the count of layers: none
    double done_ = 0.0;
    std::vector<glm::vec3> albedo_;                                  ///< by texel
    std::vector<std::vector<glm::vec3>> direct_, light_, radiance_;  ///< by layer and texel
    std::vector<std::uint8_t> is_open_;                              ///< by texel: not inside of something
};

bool Solver::run(std::size_t count, double share, std::size_t block, const std::function<void(std::size_t)>& work) {
    const std::size_t blocks = (count + block - 1) / block;
    std::atomic<std::size_t> finished = 0;
    std::atomic<bool> goes_on = true;
    team_.run(blocks, [&](int worker, std::size_t number) {
        if (!goes_on) return;
        for (std::size_t i = number * block; i < std::min(count, (number + 1) * block); ++i) work(i);
        const std::size_t now = ++finished;
        // The first worker is the one that asks.
        if (worker == 0 && options_.progress)
            goes_on = options_.progress(done_ + share * static_cast<double>(now) / static_cast<double>(blocks));
    });
    done_ += share;
    return goes_on;
}

glm::vec3 Solver::direct(const MapPlace& place, std::size_t lamp, bool both_sides) const {
    const render::scene::LightInView& in_view = of_strength_1_[lamp];
    glm::vec3 towards = in_view.towards;
    float share = 1.0f, length = 1e30f;
    if (lights_[lamp].type != world::LightType::directional) {
        const auto at = render::software::light_at<render::software::OnePoint>(in_view, place.position);
        towards = at.towards;
        share = at.share;
        length = glm::length(in_view.position - place.position) - lift_m;
    }
    float cosine = glm::dot(place.normal, towards);
    glm::vec3 side = place.side;
    if (both_sides) {
        if (glm::dot(place.side, towards) < 0.0f) side = -side;
        cosine = 0.5f * std::abs(cosine);
    } else if (glm::dot(place.side, towards) <= 0.0f) {
        return glm::vec3(0.0f);
    }
    if (!(cosine > 0.0f) || !(share > 0.0f)) return glm::vec3(0.0f);
    return glm::vec3(cosine * share * scene_.open_share({place.position + side * lift_m, towards, length}));
}

glm::vec3 Solver::of_area_lamps(const MapPlace& place, bool both_sides, const std::vector<float>& sums, int first,
                                int rays, const glm::vec2& shift) const {
    glm::vec3 sum(0.0f);
    for (int i = first; i < first + rays; ++i) {
        const auto lamp = area_lamps_.sample(sums, place.position, spread_point(i, shift));
        if (!lamp) continue;
        float cosine = glm::dot(place.normal, lamp->towards);
        glm::vec3 side = place.side;
        if (both_sides) {
            if (glm::dot(place.side, lamp->towards) < 0.0f) side = -side;
            cosine = 0.5f * std::abs(cosine);
        }
        if (!(cosine > 0.0f) || glm::dot(side, lamp->towards) <= 0.0f) continue;
        const Ray ray{place.position + side * lift_m, lamp->towards, lamp->distance - 2.0f * lift_m};
        sum += lamp->light * (cosine * scene_.open_share(ray));
    }
    return sum / static_cast<float>(rays);
}

void Solver::find_direct() {
    constexpr int points = 4;
    const auto& texels = map_.texels();
    for (auto* const all : {&direct_, &light_, &radiance_})
        all->assign(sources_.size(), std::vector<glm::vec3>(texels.size()));
    albedo_.resize(texels.size());
    is_open_.resize(texels.size());
    run(texels.size(), 0.02, block_of_texels, [&](std::size_t i) {
        const MapTexel& texel = texels[i];
        const world::Material& material = *scene_.surfaces()[texel.surface].material;
        const glm::vec2 shift = shift_of(1, texel.index);
        for (int k = 0; k < points; ++k) {
            const MapPlace place = map_.place(texel, spread_point(k, shift) - 0.5f);
            const glm::vec3 base(scene_.base_color(texel.surface, texel.triangle, place.shares));
            // What is mirrored goes on too: a twenty-fifth of all, and of metals their colour.
            albedo_[i] += glm::clamp(base * (0.96f + 0.04f * material.metallic) + 0.04f * (1.0f - material.metallic),
                                     0.0f, 0.98f) /
                          static_cast<float>(points);
            for (std::size_t layer = 0; layer < sources_.size(); ++layer)
                for (const std::size_t lamp : sources_[layer].lamps)
                    direct_[layer][i] += direct(place, lamp, is_two_sided(texel)) / static_cast<float>(points);
        }
    });
}

Solver::Met Solver::look(const Ray& ray, std::span<glm::vec3> sum, AreaLampsCount lamps) const {
    float through = 1.0f;
    const auto hit = scene_.first_hit(ray, through);
    if (!hit) {
        const auto kind = ray.along.z > 0.0f ? LightSource::sky : LightSource::ground;
        for (std::size_t layer = 0; layer < sources_.size(); ++layer)
            if (sources_[layer].kind == kind) sum[layer] += through;
        return {};
    }
    const RaySurface& surface = scene_.surfaces()[hit->surface];
    const glm::vec3 at = surface.position_at(hit->triangle, hit->shares);
    Met met{!hit->is_front && !surface.material->double_sided && surface.is_lit, glm::distance(ray.from, at)};
    if (met.is_inside) return met;
    const std::int32_t texel = map_.texel_at(*hit);
    for (std::size_t layer = 0; layer < sources_.size(); ++layer) {
        if (texel >= 0) sum[layer] += radiance_[layer][static_cast<std::size_t>(texel)] * through;
        if (layer == glow_layer_ && (lamps == AreaLampsCount::yes || !AreaLamps::is_lamp(surface)))
            sum[layer] += scene_.glow(hit->surface, hit->triangle, hit->shares) * through;
    }
    return met;
}

bool Solver::gather(const MapTexel& texel, int rays, std::uint64_t stream, Gathered& sum) const {
    const glm::vec2 shift = shift_of(stream, texel.index), moved = shift_of(stream + 1, texel.index);
    const bool both_sides = is_two_sided(texel);
    static thread_local std::vector<float> lamps;
    if (!area_lamps_.empty()) {
        const MapPlace middle = map_.place(texel);
        area_lamps_.weigh(middle.position, middle.normal, both_sides, lamps);
    }
    int counted = 0;
    for (int first = 0; first < rays; first += rays_of_place) {
        const MapPlace place = map_.place(texel, spread_point(first / rays_of_place, moved) - 0.5f);
        if (place.side == glm::vec3(0.0f)) return false;
        const Basis basis(place.normal);
        Gathered part{};
        int inside = 0;
        for (int i = first; i < first + rays_of_place; ++i) {
            glm::vec3 along = basis.turned(by_cosine(spread_point(i, shift)));
            glm::vec3 side = place.side;
            if (both_sides && i % 2 == 1) {
                along = -along;
                side = -side;
            }
            // A bent normal sends rays behind the surface: nothing comes from there.
            if (glm::dot(along, side) <= 0.0f) continue;
            inside += look({place.position + side * lift_m, along}, part).is_inside;
        }
        if (inside > most_insides) continue;
        if (!area_lamps_.empty())
            part[glow_layer_] += of_area_lamps(place, both_sides, lamps, first / rays_of_place * lamp_rays_of_place,
                                               lamp_rays_of_place, shift) *
                                 static_cast<float>(rays_of_place);
        counted += rays_of_place;
        for (std::size_t layer = 0; layer < sources_.size(); ++layer) sum[layer] += part[layer];
    }
    if (counted == 0) return false;
    for (std::size_t layer = 0; layer < sources_.size(); ++layer) sum[layer] *= 1.0f / static_cast<float>(counted);
    return true;
}

bool Solver::gather_all(int rays, std::uint64_t stream, double share) {
    const auto& texels = map_.texels();
    return run(texels.size(), share, block_of_texels, [&](std::size_t i) {
        Gathered sum{};
        is_open_[i] = gather(texels[i], rays, stream, sum);
        for (std::size_t layer = 0; layer < sources_.size(); ++layer) light_[layer][i] = sum[layer];
    });
}

void Solver::find_radiance() {
    for (std::size_t layer = 0; layer < sources_.size(); ++layer)
        for (std::size_t i = 0; i < albedo_.size(); ++i)
            radiance_[layer][i] = albedo_[i] * (light_[layer][i] + direct_[layer][i]);
}

/// Texels beside each other on one surface, in the order of the map.
template <typename Use>
void each_neighbor(const LightMap& map, const MapTexel& texel, int reach, const Use& use) {
    const int width = map.size().width, height = map.size().height;
    const int x0 = static_cast<int>(texel.index) % width, y0 = static_cast<int>(texel.index) / width;
    for (int y = std::max(0, y0 - reach); y <= std::min(height - 1, y0 + reach); ++y) {
        for (int x = std::max(0, x0 - reach); x <= std::min(width - 1, x0 + reach); ++x) {
            const std::int32_t number = map.texel_of_index()[static_cast<std::size_t>(y * width + x)];
            if (number < 0 || map.texels()[static_cast<std::size_t>(number)].surface != texel.surface) continue;
            use(static_cast<std::size_t>(number), x - x0, y - y0);
        }
    }
}

void Solver::mend_insides() {
    constexpr int passes = 8;
    const auto& texels = map_.texels();
    std::vector<std::uint8_t> is_good = is_open_;
    for (int pass = 0; pass < passes; ++pass) {
        std::vector<std::size_t> mended;
        for (std::size_t i = 0; i < texels.size(); ++i) {
            if (is_good[i] != 0) continue;
            float weight = 0.0f;
            Gathered sum{};
            each_neighbor(map_, texels[i], 1, [&](std::size_t other, int, int) {
                if (is_good[other] == 0) return;
                weight += 1.0f;
                for (std::size_t layer = 0; layer < sources_.size(); ++layer) sum[layer] += light_[layer][other];
            });
            if (weight == 0.0f) continue;
            for (std::size_t layer = 0; layer < sources_.size(); ++layer) light_[layer][i] = sum[layer] / weight;
            mended.push_back(i);
        }
        for (const std::size_t i : mended) is_good[i] = 1;
        if (mended.empty()) return;
    }
}

void Solver::smooth() {
    const auto& texels = map_.texels();
    std::vector<MapPlace> places(texels.size());
    run(texels.size(), 0.005, block_of_texels, [&](std::size_t i) { places[i] = map_.place(texels[i]); });
    for (int pass = 0; pass < 2; ++pass) {
        auto made = light_;
        run(texels.size(), 0.005, block_of_texels, [&](std::size_t i) {
            float weight = 0.0f;
            Gathered sum{};
            each_neighbor(map_, texels[i], 2, [&](std::size_t other, int dx, int dy) {
                if (is_open_[other] == 0) return;
                const glm::vec3 gap = places[other].position - places[i].position;
                // Of one plane, and beside each other there as they are in the map.
                if (glm::dot(places[other].normal, places[i].normal) < 0.95f) return;
                if (std::abs(glm::dot(gap, places[i].side)) > 0.2f * glm::length(gap) + 1e-3f) return;
                const float share = std::exp2(-0.5f * static_cast<float>(dx * dx + dy * dy));
                weight += share;
                for (std::size_t layer = 0; layer < sources_.size(); ++layer)
                    sum[layer] += light_[layer][other] * share;
            });
            if (weight == 0.0f) return;
            for (std::size_t layer = 0; layer < sources_.size(); ++layer) made[layer][i] = sum[layer] / weight;
        });
        light_ = std::move(made);
    }
}

void Solver::find_probes(Transport& to, double share) {
    const std::size_t count = grid_.size();
    to.probes.assign(sources_.size(), std::vector<world::LightProbe>(count));
    to.is_open.assign(count, 0);
    run(count, share, block_of_texels, [&](std::size_t number) {
        const auto x = number % static_cast<std::size_t>(grid_.count.x);
        const auto y = number / static_cast<std::size_t>(grid_.count.x) % static_cast<std::size_t>(grid_.count.y);
        const auto z = number / static_cast<std::size_t>(grid_.count.x) / static_cast<std::size_t>(grid_.count.y);
        const glm::vec3 from(grid_.first + grid_.spacing_m * glm::dvec3(x, y, z));
        const glm::vec2 shift = shift_of(7, number);
        int inside = 0;
        for (int i = 0; i < options_.probe_rays; ++i) {
            const glm::vec3 along = to_all_sides(spread_point(i, shift));
            Gathered sum{};
            inside += look({from, along}, sum).is_inside;
            for (std::size_t layer = 0; layer < sources_.size(); ++layer) {
                world::LightProbe& probe = to.probes[layer][number];
                probe.mean += sum[layer];
                for (glm::length_t c = 0; c < 3; ++c) probe.along[c] += sum[layer] * (2.0f * along[c]);
            }
        }
        const float part = 1.0f / static_cast<float>(options_.probe_rays);
        to.is_open[number] = static_cast<float>(inside) * part < 0.1f;
        for (auto& layer : to.probes) layer[number] = layer[number].scaled(glm::vec3(part));
        // As the two terms of a light from one direction: a quarter, and a half along it.
        const auto add = [&](std::size_t layer, const glm::vec3& arriving, const glm::vec3& towards) {
            world::LightProbe& probe = to.probes[layer][number];
            probe.mean += 0.25f * arriving;
            for (glm::length_t c = 0; c < 3; ++c) probe.along[c] += arriving * (0.5f * towards[c]);
        };
        // Lamps are points, or as small: no ray meets them.
        for (std::size_t layer = 0; layer < sources_.size(); ++layer) {
            for (const std::size_t lamp : sources_[layer].lamps) {
                const world::Light& light = lights_[lamp];
                if (light.type == world::LightType::directional) continue;
                const glm::vec3 way = glm::vec3(light.position) - from;
                const float length = glm::length(way);
                if (length < 1e-3f) continue;
                const MapPlace place{from, way / length, way / length, {}};
                add(layer, direct(place, lamp, false), place.side);
            }
        }
        static thread_local std::vector<float> lamps;
        if (!area_lamps_.empty()) area_lamps_.weigh(from, glm::vec3(0.0f), false, lamps);
        for (int i = 0; !area_lamps_.empty() && i < lamp_rays_of_probe; ++i) {
            const auto lamp = area_lamps_.sample(lamps, from, spread_point(i, shift));
            if (!lamp) continue;
            const float open = scene_.open_share({from, lamp->towards, lamp->distance - lift_m});
            add(glow_layer_, lamp->light * (open / static_cast<float>(lamp_rays_of_probe)), lamp->towards);
        }
    });
}

void Solver::find_reflections(Transport& to, double share) {
    to.reflection_probes.places = reflection_places(scene_, of_, grid_, to.is_open, options_.most_reflections);
    const auto& places = to.reflection_probes.places;
    std::vector<ReflectionView> views(places.size());
    const auto look_along = [this](const Ray& ray, std::span<glm::vec3> by_layer) {
        return look(ray, by_layer, AreaLampsCount::yes).distance;
    };
    run(places.size(), share, 1,
        [&](std::size_t i) { views[i] = reflection_view(places[i], sources_.size(), look_along); });
    to.reflections.assign(sources_.size(), {});
    for (const ReflectionView& view : views) {
        to.reflection_probes.nearness.insert(to.reflection_probes.nearness.end(), view.nearness.begin(),
                                             view.nearness.end());
        for (std::size_t layer = 0; layer < view.texels.size(); ++layer)
            to.reflections[layer].insert(to.reflections[layer].end(), view.texels[layer].begin(),
                                         view.texels[layer].end());
    }
}

double Solver::total(std::size_t layer) const {
    double sum = 0.0;
    for (const glm::vec3& light : light_[layer]) sum += static_cast<double>(light.r) + light.g + light.b;
    return sum;
}

/// All of the bounces that count, from what the checkpoint has. False: it was ended.
bool Solver::bounce_all(double share) {
    const int done = options_.checkpoint != nullptr ? options_.checkpoint->resume(light_) : 0;
    const double part = share / std::max(1, options_.bounces), end = done_ + share;
    done_ += part * std::min(done, options_.bounces);
    find_radiance();
    bool is_settled = false;
    for (int bounce = done; bounce < options_.bounces && !is_settled; ++bounce) {
        std::vector<double> before(sources_.size());
        for (std::size_t layer = 0; layer < before.size(); ++layer) before[layer] = total(layer);
        if (!gather_all(options_.coarse_rays, 100 + 2 * static_cast<std::uint64_t>(bounce), part)) return false;
        mend_insides();
        find_radiance();
        is_settled = true;
        for (std::size_t layer = 0; layer < before.size(); ++layer)
            is_settled = is_settled && std::abs(total(layer) - before[layer]) <= settled_share * before[layer];
        // After the last one there is none to go on with, however many were allowed.
        if (options_.checkpoint != nullptr)
            options_.checkpoint->keep(is_settled ? options_.bounces : bounce + 1, light_);
    }
    done_ = end;
    return true;
}

Transport Solver::solve() {
    Transport made;
    find_direct();
    const double coarse = options_.coarse_rays * options_.bounces, fine = options_.rays;
    const double part = 0.9 / (coarse + fine);
    if (!bounce_all(part * coarse)) return made;
    if (!gather_all(options_.rays, 10, part * fine)) return made;
    mend_insides();
    find_radiance();
    smooth();
    find_probes(made, 0.05);
    find_reflections(made, 0.01);
    made.texels.assign(sources_.size(), {});
    for (std::size_t layer = 0; layer < sources_.size(); ++layer) {
        // A directional light's own part is drawn, with its shadows.
        const bool has_direct = sources_[layer].kind == LightSource::lamp &&
                                lights_[sources_[layer].lamps.front()].type != world::LightType::directional;
        made.texels[layer] = std::move(light_[layer]);
        if (!has_direct) continue;
        for (std::size_t i = 0; i < made.texels[layer].size(); ++i) made.texels[layer][i] += direct_[layer][i];
    }
    made.is_whole = true;
    return made;
}

}  // namespace

Transport find_transport(const RayScene& scene, const LightMap& map, std::span<const Source> sources,
                         const world::Scene& of, const world::ProbeGrid& grid, const TransportOptions& options) {
    return Solver(scene, map, sources, of, grid, options).solve();
}

}  // namespace camrig::bake
