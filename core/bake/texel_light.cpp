#include "core/bake/texel_light.h"

#include <algorithm>
#include <cmath>

#include "core/bake/ray_sampling.h"
#include "core/render/software/lambert.h"
#include "core/render/surface_tables.h"

namespace camrig::bake {
namespace {

using world::LightSource;

/// A texel's places have so many rays each. A place from which more of them meet the inside of something is within
/// that, or under it, and counts for nothing;
constexpr int rays_of_place = 16, most_insides = 2;
/// but where all of a texel is so and what is over it is a sheet that faces as it does, as a seat without a bottom, it
/// lies in the shade of that, if no more of them meet it.
constexpr int most_above = 12;
constexpr float faces_alike = 0.7f;
/// Beside them, so many to lamps.
constexpr int lamp_rays_of_place = 4;
/// Whether a side of something thin is seen is told by so many rays: by what of their light comes from farther than
/// this.
constexpr int rays_of_side = 64;
constexpr float seen_from_m = 3.0f;
/// No surface sends on all of what it gets: between two of those light would never end.
constexpr float most_sent_on = 0.98f;
/// What is rougher spreads what it mirrors so wide that it is as good as a share of all that comes to it.
constexpr float most_mirroring = 0.5f;
/// A bounce that adds no more than this to any layer is the last.
constexpr double settled_share = 0.003;

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

/// Which side of a place light falls on, and how much that counts: by its angle, and by who sees the side.
struct LitSide {
    glm::vec3 side;
    float cosine;
};
LitSide lit_side(const MapPlace& place, const glm::vec3& towards, float front_share) {
    const float cosine = glm::dot(place.normal, towards);
    if (glm::dot(place.side, towards) > 0.0f) return {place.side, cosine * front_share};
    return {-place.side, -cosine * (1.0f - front_share)};
}

/// What of the light that comes to a surface from all around leaves it for a view at that cosine, as it is drawn: in
/// its color from its base and, of metal, from its surface; and from the surface of what is no metal.
struct SentOn {
    float base, metal, surface;
};
SentOn sent_on(const world::Material& material, float cosine) {
    static const std::vector<glm::vec2> reflectance = render::make_reflectance_table();
    constexpr int side = render::table_side;
    const float column = glm::clamp(cosine, 0.0f, 1.0f) * (side - 1);
    const float row = glm::clamp(material.roughness, 0.0f, 1.0f) * (side - 1);
    const int left = std::min(static_cast<int>(column), side - 2), upper = std::min(static_cast<int>(row), side - 2);
    const auto at = [&](int y) {
        const auto* const first = &reflectance[static_cast<std::size_t>(y * side + left)];
        return glm::mix(first[0], first[1], column - static_cast<float>(left));
    };
    const glm::vec2 of_f0 = glm::mix(at(upper), at(upper + 1), row - static_cast<float>(upper));
    const float mirrored = render::dielectric_f0 * of_f0.x + of_f0.y;
    return {(1.0f - material.metallic) * render::share_of_base(cosine), material.metallic,
            (1.0f - material.metallic) * mirrored};
}

}  // namespace

TexelLight::TexelLight(const RayScene& scene, const LightMap& map, std::span<const Source> sources,
                       std::span<const world::Light> lamps, const TransportOptions& options, BakeTeam& team)
    : scene_(scene), map_(map), sources_(sources), lights_(lamps), options_(options), team_(team), area_lamps_(scene) {
    const auto glow = std::ranges::find(sources, LightSource::glow, &Source::kind);
    glow_layer_ = static_cast<std::size_t>(glow - sources.begin());
    for (world::Light light : lights_) {
        light.color = glm::vec3(1.0f);
        light.intensity = 1.0f;
        of_strength_1_.push_back(render::scene::light_in_view(light, {}, 1.0f));
    }
}

float TexelLight::front_share(const MapTexel& texel) const {
    if (!scene_.surfaces()[texel.surface].material->double_sided) return 1.0f;
    const MapPlace place = map_.place(texel);
    if (place.side == glm::vec3(0.0f)) return 0.5f;
    const Basis basis(place.side);
    const glm::vec2 shift = shift_of(0, texel.index);
    // As long as nothing is known both are seen alike.
    float front = 1.0f, back = 1.0f;
    for (int i = 0; i < rays_of_side; ++i) {
        const glm::vec3 along = basis.turned(by_cosine(spread_point(i, shift))), lift = place.side * lift_m;
        front += scene_.open_share({place.position + lift, along, seen_from_m}).g;
        back += scene_.open_share({place.position - lift, -along, seen_from_m}).g;
    }
    return front / (front + back);
}

glm::vec3 TexelLight::direct(const MapPlace& place, std::size_t lamp, float front_share) const {
    const render::scene::LightInView& in_view = of_strength_1_[lamp];
    glm::vec3 towards = in_view.towards;
    float share = 1.0f, length = 1e30f;
    if (lights_[lamp].type != world::LightType::directional) {
        const auto at = render::software::light_at<render::software::OnePoint>(in_view, place.position);
        towards = at.towards;
        share = at.share;
        length = glm::length(in_view.position - place.position) - lift_m;
    }
    const LitSide lit = lit_side(place, towards, front_share);
    if (!(lit.cosine > 0.0f) || !(share > 0.0f)) return glm::vec3(0.0f);
    return lit.cosine * share * scene_.open_share({place.position + lit.side * lift_m, towards, length});
}

glm::vec3 TexelLight::of_area_lamps(const MapPlace& place, float front_share, const std::vector<float>& sums, int first,
                                    int rays, const glm::vec2& shift) const {
    glm::vec3 sum(0.0f);
    for (int i = first; i < first + rays; ++i) {
        const auto lamp = area_lamps_.sample(sums, place.position, spread_point(i, shift));
        if (!lamp) continue;
        const LitSide lit = lit_side(place, lamp->towards, front_share);
        if (!(lit.cosine > 0.0f)) continue;
        const Ray ray{place.position + lit.side * lift_m, lamp->towards, lamp->distance - 2.0f * lift_m};
        sum += lamp->light * lit.cosine * scene_.open_share(ray);
    }
    return sum / static_cast<float>(rays);
}

void TexelLight::find_direct() {
    constexpr int points = 4;
    const auto& texels = map_.texels();
    for (auto* const all : {&direct_, &light_, &arriving_})
        all->assign(sources_.size(), std::vector<glm::vec3>(texels.size()));
    colors_.resize(texels.size());
    front_shares_.resize(texels.size());
    is_open_.resize(texels.size());
    places_.resize(texels.size());
    sides_m_.resize(texels.size());
    team_.run(texels.size(), 0.02, BakeTeam::usual_block, [&](std::size_t i) {
        const MapTexel& texel = texels[i];
        const glm::vec2 shift = shift_of(1, texel.index);
        front_shares_[i] = front_share(texel);
        places_[i] = map_.place(texel);
        sides_m_[i] = map_.side_m(texel);
        for (int k = 0; k < points; ++k) {
            const MapPlace place = map_.place(texel, spread_point(k, shift) - 0.5f);
            const glm::vec3 base(scene_.base_color(texel.surface, texel.triangle, place.shares));
            colors_[i] += glm::clamp(base, 0.0f, 1.0f) / static_cast<float>(points);
            for (std::size_t layer = 0; layer < sources_.size(); ++layer)
                for (const std::size_t lamp : sources_[layer].lamps)
                    direct_[layer][i] += direct(place, lamp, front_shares_[i]) / static_cast<float>(points);
        }
    });
}

TexelLight::Met TexelLight::look(const Ray& ray, std::span<glm::vec3> sum, AreaLampsCount lamps,
                                 MirrorsAreMet mirrors) const {
    glm::vec3 through;
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
    if (met.is_inside) {
        met.side = surface.side_of(hit->triangle);
        return met;
    }
    const std::int32_t number = map_.texel_at(*hit);
    const auto texel = static_cast<std::size_t>(std::max(number, 0));
    glm::vec3 sent_on_of_it(0.0f), mirrored(0.0f);
    bool is_mirror = false;
    Gathered seen;  // in a mirror
    if (number >= 0) {
        glm::vec3 side = surface.side_of(hit->triangle);
        const float cosine = glm::dot(side, ray.along);
        if (cosine > 0.0f) side = -side;
        const SentOn sent = sent_on(*surface.material, std::abs(cosine));
        const glm::vec3 of_base = colors_[texel] * sent.base, of_surface = colors_[texel] * sent.metal + sent.surface;
        is_mirror = mirrors == MirrorsAreMet::yes && surface.material->roughness < most_mirroring;
        if (is_mirror) {
            seen.fill(glm::vec3(0.0f));
            sent_on_of_it = through * of_base;
            mirrored = through * glm::min(of_surface, most_sent_on - of_base);
            look({at + side * lift_m, glm::reflect(ray.along, side)}, seen, AreaLampsCount::yes, MirrorsAreMet::no);
        } else {
            sent_on_of_it = through * glm::min(of_base + of_surface, most_sent_on);
        }
    }
    for (std::size_t layer = 0; layer < sources_.size(); ++layer) {
        glm::vec3 sent(0.0f);
        if (number >= 0) sent = arriving_[layer][texel] * sent_on_of_it;
        // Lamps that are points are met by no ray.
        if (is_mirror) sent += (seen[layer] + direct_[layer][texel]) * mirrored;
        sum[layer] += sent;
        if (layer == glow_layer_ && (lamps == AreaLampsCount::yes || !AreaLamps::is_lamp(surface)))
            sum[layer] += scene_.glow(hit->surface, hit->triangle, hit->shares) * through;
    }
    return met;
}

bool TexelLight::gather(std::size_t number, int rays, std::uint64_t stream, Gathered& sum) const {
    const MapTexel& texel = map_.texels()[number];
    const glm::vec2 shift = shift_of(stream, texel.index), moved = shift_of(stream + 1, texel.index);
    const float front_share = front_shares_[number];
    const bool both_sides = front_share < 1.0f;
    static thread_local std::vector<float> lamps;
    if (!area_lamps_.empty()) {
        const MapPlace middle = map_.place(texel);
        area_lamps_.weigh(middle.position, middle.normal, both_sides, lamps);
    }
    int counted = 0, shaded = 0;
    Gathered in_shade{};
    for (int first = 0; first < rays; first += rays_of_place) {
        const MapPlace place = map_.place(texel, spread_point(first / rays_of_place, moved) - 0.5f);
        if (place.side == glm::vec3(0.0f)) return false;
        const Basis basis(place.normal);
        std::array<Gathered, 2> of_sides{};
        int inside = 0, above = 0;
        for (int i = first; i < first + rays_of_place; ++i) {
            glm::vec3 along = basis.turned(by_cosine(spread_point(i, shift)));
            glm::vec3 side = place.side;
            const bool is_behind = both_sides && i % 2 == 1;
            if (is_behind) {
                along = -along;
                side = -side;
            }
            // A bent normal sends rays behind the surface: nothing comes from there.
            if (glm::dot(along, side) <= 0.0f) continue;
            const Met met = look({place.position + side * lift_m, along}, of_sides[is_behind]);
            if (met.is_inside) ++(glm::dot(met.side, side) > faces_alike ? above : inside);
        }
        if (inside > most_insides || above > most_above) continue;
        Gathered part = of_sides[0];
        for (std::size_t layer = 0; both_sides && layer < sources_.size(); ++layer)
            part[layer] = 2.0f * (front_share * part[layer] + (1.0f - front_share) * of_sides[1][layer]);
        if (!area_lamps_.empty())
            part[glow_layer_] += of_area_lamps(place, front_share, lamps, first / rays_of_place * lamp_rays_of_place,
                                               lamp_rays_of_place, shift) *
                                 static_cast<float>(rays_of_place);
        const bool is_open = inside + above <= most_insides;
        (is_open ? counted : shaded) += rays_of_place;
        Gathered& to = is_open ? sum : in_shade;
        for (std::size_t layer = 0; layer < sources_.size(); ++layer) to[layer] += part[layer];
    }
    if (counted == 0) {
        sum = in_shade;
        counted = shaded;
    }
    if (counted == 0) return false;
    for (std::size_t layer = 0; layer < sources_.size(); ++layer) sum[layer] *= 1.0f / static_cast<float>(counted);
    return true;
}

bool TexelLight::gather_all(int rays, std::uint64_t stream, double share) {
    const auto& texels = map_.texels();
    return team_.run(texels.size(), share, BakeTeam::usual_block, [&](std::size_t i) {
        Gathered sum{};
        is_open_[i] = gather(i, rays, stream, sum);
        for (std::size_t layer = 0; layer < sources_.size(); ++layer) light_[layer][i] = sum[layer];
    });
}

void TexelLight::find_arriving() {
    for (std::size_t layer = 0; layer < sources_.size(); ++layer)
        for (std::size_t i = 0; i < colors_.size(); ++i) arriving_[layer][i] = light_[layer][i] + direct_[layer][i];
}

/// Charts that only lie beside each other in the map are other rooms.
bool TexelLight::are_beside(std::size_t one, std::size_t other, int dx, int dy) const {
    const float steps = std::sqrt(static_cast<float>(dx * dx + dy * dy));
    return glm::distance(places_[one].position, places_[other].position) <= 1.6f * steps * sides_m_[one] + 1e-3f;
}

void TexelLight::mend_insides() {
    constexpr int passes = 8;
    const auto& texels = map_.texels();
    std::vector<std::uint8_t> is_good = is_open_;
    for (int pass = 0; pass < passes; ++pass) {
        std::vector<std::size_t> mended;
        for (std::size_t i = 0; i < texels.size(); ++i) {
            if (is_good[i] != 0) continue;
            float weight = 0.0f;
            Gathered sum{};
            each_neighbor(map_, texels[i], 1, [&](std::size_t other, int dx, int dy) {
                if (is_good[other] == 0 || !are_beside(i, other, dx, dy)) return;
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

void TexelLight::smooth() {
    const auto& texels = map_.texels();
    for (int pass = 0; pass < 2; ++pass) {
        auto made = light_;
        team_.run(texels.size(), 0.005, BakeTeam::usual_block, [&](std::size_t i) {
            float weight = 0.0f;
            Gathered sum{};
            each_neighbor(map_, texels[i], 2, [&](std::size_t other, int dx, int dy) {
                if (is_open_[other] == 0 || !are_beside(i, other, dx, dy)) return;
                const glm::vec3 gap = places_[other].position - places_[i].position;
                // Of one plane.
                if (glm::dot(places_[other].normal, places_[i].normal) < 0.95f) return;
                if (std::abs(glm::dot(gap, places_[i].side)) > 0.2f * glm::length(gap) + 1e-3f) return;
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

double TexelLight::total(std::size_t layer) const {
    double sum = 0.0;
    for (const glm::vec3& light : light_[layer]) sum += static_cast<double>(light.r) + light.g + light.b;
    return sum;
}

/// All of the bounces that count, from what the checkpoint has. False: it was ended.
bool TexelLight::bounce_all(double share) {
    const int done = options_.checkpoint != nullptr ? options_.checkpoint->resume(light_) : 0;
    const double part = share / std::max(1, options_.bounces), end = team_.done() + share;
    team_.set_done(team_.done() + part * std::min(done, options_.bounces));
    find_arriving();
    bool is_settled = false;
    for (int bounce = done; bounce < options_.bounces && !is_settled; ++bounce) {
        std::vector<double> before(sources_.size());
        for (std::size_t layer = 0; layer < before.size(); ++layer) before[layer] = total(layer);
        if (!gather_all(options_.coarse_rays, 100 + 2 * static_cast<std::uint64_t>(bounce), part)) return false;
        mend_insides();
        find_arriving();
        is_settled = true;
        for (std::size_t layer = 0; layer < before.size(); ++layer)
            is_settled = is_settled && std::abs(total(layer) - before[layer]) <= settled_share * before[layer];
        // After the last one there is none to go on with, however many were allowed.
        if (options_.checkpoint != nullptr)
            options_.checkpoint->keep(is_settled ? options_.bounces : bounce + 1, light_);
    }
    team_.set_done(end);
    return true;
}

bool TexelLight::solve() {
    find_direct();
    const double coarse = options_.coarse_rays * options_.bounces, fine = options_.rays;
    const double part = 0.9 / (coarse + fine);
    if (!bounce_all(part * coarse)) return false;
    if (!gather_all(options_.rays, 10, part * fine)) return false;
    mend_insides();
    find_arriving();
    smooth();
    return true;
}

std::vector<std::vector<glm::vec3>> TexelLight::take_texels() {
    for (std::size_t layer = 0; layer < sources_.size(); ++layer) {
        // A directional light's own part is drawn, with its shadows.
        const bool has_direct = sources_[layer].kind == LightSource::lamp &&
                                lights_[sources_[layer].lamps.front()].type != world::LightType::directional;
        if (!has_direct) continue;
        for (std::size_t i = 0; i < light_[layer].size(); ++i) light_[layer][i] += direct_[layer][i];
    }
    return std::move(light_);
}

}  // namespace camrig::bake
