#include "core/bake/bake.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "core/bake/light_map.h"
#include "core/bake/ray_scene.h"
#include "core/bake/rect_packing.h"
#include "core/bake/transport.h"
#include "core/bake/unwrap.h"
#include "core/base/digest.h"
#include "core/world/baked/baked_light_header.h"
#include "core/world/baked/shared_exponent.h"
#include "core/world/world.h"

namespace camrig::bake {
namespace {

using render::scene::PlacedScene;
using render::scene::PlacedSurface;
using world::BakedLight;

/// Whether a surface of what stands still takes part: rigid, lit, and not see-through.
bool takes_part(const PlacedSurface& surface) {
    return surface.deformation < 0 && surface.primitive->is_lit && !surface.primitive->is_blended &&
           surface.primitive->source->topology == world::Topology::triangles;
}

/// Rays are of floats, whose steps beyond this are as long as what keeps a ray off its own surface (lift_m).
constexpr double farthest_m = 4000.0;

/// How far from the world's origin the nearest of what takes part is.
double nearest_m(const PlacedScene& scene) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const PlacedSurface& surface : scene.statics().all())
        if (takes_part(surface)) nearest = std::min(nearest, glm::length(surface.middle()));
    return nearest;
}

/// How large a unit of a surface's mesh is in the world.
double scale_of(const PlacedSurface& surface) {
    return std::cbrt(std::abs(glm::determinant(glm::dmat3(surface.world_from_local))));
}

PlacedScene placed(const world::SceneRef& scene) {
    PlacedScene made(std::make_shared<render::scene::PreparedModels>());
    auto world = world::World::create(scene, scene->seed);
    CHECK(world.has_value());
    made.place((*world)->snapshot(0));
    return made;
}

/// The charts of the models of what stands still, each at the largest scale that it stands at.
std::vector<world::BakedModel> cut_models(const PlacedScene& scene, double texels_per_m) {
    struct Of {
        std::vector<const world::Primitive*> sources;
        std::vector<double> scales;  ///< 0: takes no part
    };
    std::map<std::string, Of> models;
    for (const PlacedSurface& surface : scene.statics().all()) {
        if (!takes_part(surface)) continue;
        Of& of = models[surface.object->model_name];
        if (of.scales.empty()) {
            for (const auto& primitive : surface.model->primitives) of.sources.push_back(primitive.source);
            of.scales.resize(of.sources.size());
        }
        double& scale = of.scales[surface.primitive->number];
        scale = std::max(scale, scale_of(surface));
    }
    std::vector<world::BakedModel> made;
    for (const auto& [name, of] : models) {
        world::BakedModel& model = made.emplace_back();
        model.name = name;
        for (std::size_t i = 0; i < of.sources.size(); ++i)
            model.primitives.push_back(of.scales[i] > 0.0 ? unwrap(*of.sources[i], texels_per_m * of.scales[i])
                                                          : world::BakedPrimitive{});
    }
    return made;
}

/// Rectangles for all surfaces that take part; false: they do not fit.
bool lay_out(const PlacedScene& scene, int max_side, BakedLight& light) {
    light.objects.clear();
    std::vector<ImageSize> sizes;
    std::vector<std::pair<std::size_t, std::size_t>> owners;
    for (const world::Instance& object : scene.snapshot()->statics->objects) {
        const auto model = std::ranges::find(light.models, object.info->model_name, &world::BakedModel::name);
        if (model == light.models.end()) continue;
        world::BakedObject& made = light.objects.emplace_back();
        made.name = object.info->name;
        made.model = object.info->model_name;
        made.position = object.position;
        made.orientation = object.orientation;
        made.scale = object.scale;
        for (const PlacedSurface& surface : scene.statics().all()) {
            if (surface.object != object.info.get() || !takes_part(surface)) continue;
            if (model->primitives[surface.primitive->number].size.width == 0) continue;
            made.surfaces.push_back({surface.node, surface.primitive->number, 0, 0});
        }
        std::ranges::sort(made.surfaces, world::is_before);
        for (std::size_t i = 0; i < made.surfaces.size(); ++i) {
            sizes.push_back(model->primitives[made.surfaces[i].primitive].size);
            owners.emplace_back(light.objects.size() - 1, i);
        }
    }
    const auto packed = pack_tightly(sizes, max_side);
    if (!packed) return false;
    light.size = packed->area;
    for (std::size_t i = 0; i < owners.size(); ++i) {
        world::BakedSurface& surface = light.objects[owners[i].first].surfaces[owners[i].second];
        surface.x = static_cast<std::uint16_t>(packed->places[i].x);
        surface.y = static_cast<std::uint16_t>(packed->places[i].y);
    }
    return true;
}

world::ProbeGrid grid_over(const RayScene& scene, const BakeOptions& options, std::size_t layers) {
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    for (const RaySurface& surface : scene.surfaces()) {
        if (!surface.is_lit) continue;
        for (const glm::vec3& position : surface.positions) {
            low = glm::min(low, glm::dvec3(position));
            high = glm::max(high, glm::dvec3(position));
        }
    }
    world::ProbeGrid grid;
    // People are where the ground is; what is high up is few.
    constexpr double most_height_m = 12.0;
    high.z = std::min(high.z, low.z + most_height_m);
    for (grid.spacing_m = options.probe_spacing_m;; grid.spacing_m *= 1.1) {
        // The lowest ones are half a step over the ground, and those at the sides as far within.
        grid.first = low + 0.5 * grid.spacing_m;
        grid.count = glm::max(glm::ivec3(glm::ceil((high - low) / grid.spacing_m)), 1);
        if (grid.size() <= std::min(static_cast<std::size_t>(options.max_probes), world::max_light_probes / layers))
            return grid;
    }
}

/// A lamp, or all of a group.
std::vector<Source> lamps_of(const world::Scene& scene) {
    std::vector<Source> made;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const std::string& group = scene.lights[i].group;
        const auto same = std::ranges::find_if(made, [&](const Source& source) {
            return !group.empty() && scene.lights[source.lamps.front()].group == group;
        });
        if (same != made.end())
            same->lamps.push_back(i);
        else
            made.push_back({world::LightSource::lamp, {i}});
    }
    return made;
}

std::vector<Source> sources_of(const std::vector<Source>& lamps, const RayScene& rays) {
    std::vector<Source> made{{world::LightSource::sky}, {world::LightSource::ground}};
    const auto glows = [](const RaySurface& surface) {
        return !surface.is_lit || surface.material->emissive != glm::vec3(0.0f);
    };
    if (std::ranges::any_of(rays.surfaces(), glows)) made.push_back({world::LightSource::glow});
    made.insert(made.end(), lamps.begin(), lamps.end());
    return made;
}

/// What of the scene a bake takes beside that of light_key(): which way the suns shine.
std::uint64_t sun_key(const world::Scene& scene) {
    Digest digest;
    for (const world::Light& light : scene.lights) {
        if (light.type != world::LightType::directional) continue;
        for (glm::length_t i = 0; i < 3; ++i) digest.add(light.direction[i]);
    }
    return digest.value();
}

std::vector<LightMap::Origin> origins_of(const RayScene& rays, const BakedLight& light) {
    std::vector<LightMap::Origin> made;
    for (const RaySurface& surface : rays.surfaces()) {
        LightMap::Origin& origin = made.emplace_back();
        const auto object = std::ranges::find(light.objects, surface.placed->object->name, &world::BakedObject::name);
        if (object == light.objects.end()) continue;
        for (const world::BakedSurface& of : object->surfaces)
            if (of.node == surface.placed->node && of.primitive == surface.placed->primitive->number)
                origin = {true, {of.x, of.y}};
    }
    return made;
}

/// Texels that stand for nothing get what is left of them, which packs well.
std::vector<std::uint32_t> packed_texels(const LightMap& map, const std::vector<glm::vec3>& light) {
    std::vector<std::uint32_t> made(static_cast<std::size_t>(map.size().pixels()));
    std::uint32_t last = 0;
    for (std::size_t i = 0; i < made.size(); ++i) {
        const std::int32_t texel = map.texel_of_index()[i];
        if (texel >= 0) last = world::packed_light(light[static_cast<std::size_t>(texel)]);
        made[i] = last;
    }
    return made;
}

std::vector<std::uint32_t> packed(const std::vector<glm::vec3>& light) {
    std::vector<std::uint32_t> made;
    for (const glm::vec3& value : light) made.push_back(world::packed_light(value));
    return made;
}

}  // namespace

Result<world::BakedLight> bake(const world::SceneRef& scene, const BakeOptions& options) {
    BakedLight light;
    light.key = world::light_key(*scene);
    const std::vector<Source> lamps = lamps_of(*scene);
    // Beside those of sky, ground and what glows.
    const std::size_t most_layers = lamps.size() + 3;
    if (most_layers > world::max_light_layers)
        return error(
            ErrorKind::resource_exhausted,
            fmt::format("lights: {} that are switched apart, and light is kept of {}; put such as are switched "
                        "together into a group",
                        lamps.size(), world::max_light_layers - 3));
    const PlacedScene uncut = placed(scene);
    if (const double nearest = nearest_m(uncut); nearest > farthest_m && std::isfinite(nearest))
        return error(ErrorKind::invalid_argument,
                     fmt::format("all of it is {:.0f} km or more from the world's origin, where light is not found to "
                                 "a millimetre; move the scene within {:.0f} km of it",
                                 nearest / 1000.0, farthest_m / 1000.0));
    for (double texels_per_m = options.texels_per_m;; texels_per_m *= 0.9) {
        light.models = cut_models(uncut, texels_per_m);
        if (light.models.empty())
            return error(ErrorKind::invalid_argument, "nothing in this scene stands still and is lit");
        if (lay_out(uncut, options.max_side, light) &&
            static_cast<std::int64_t>(most_layers) * light.size.pixels() <= world::max_light_texels)
            break;
        if (texels_per_m < 1e-3) return error(ErrorKind::invalid_argument, "its surfaces have no room in a map");
    }
    auto cut = std::make_shared<world::Scene>(*scene);
    use_baked_light(*cut, std::make_shared<const BakedLight>(light));
    const PlacedScene stands = placed(cut);
    const RayScene rays(stands);
    const LightMap map(rays, light.size, origins_of(rays, light));
    const std::vector<Source> sources = sources_of(lamps, rays);
    light.grid = grid_over(rays, options, sources.size());
    Checkpoint checkpoint(options.checkpoint,
                          fmt::format("{:016x} {:016x} {} {} {} {} {}", light.key, sun_key(*scene), light.size.width,
                                      light.size.height, options.rays, options.bounces, options.texels_per_m));
    const TransportOptions how{.rays = options.rays,
                               .coarse_rays = std::max(16, options.rays / 8),
                               .bounces = options.bounces,
                               .most_reflections = options.reflections,
                               .threads = options.threads,
                               .checkpoint = &checkpoint,
                               .progress = options.progress};
    Transport found = find_transport(rays, map, sources, *scene, light.grid, how);
    if (!found.is_whole) return error(ErrorKind::unavailable, "it was ended");
    light.grid.is_open = std::move(found.is_open);
    light.reflection_probes = std::move(found.reflection_probes);
    for (std::size_t i = 0; i < sources.size(); ++i)
        light.layers.push_back({.source = sources[i].kind,
                                .lamps = sources[i].lamps,
                                .texels = packed_texels(map, found.texels[i]),
                                .probes = std::move(found.probes[i]),
                                .reflections = packed(found.reflections[i])});
    return light;
}

}  // namespace camrig::bake
