#include "core/render/software/software_shadows.h"

#include <algorithm>
#include <limits>

#include "core/base/cpu_meter.h"
#include "core/render/scene/shadow_casters.h"
#include "core/render/software/depth_map.h"
#include "core/render/software/rows.h"

namespace camrig::render::software {
namespace {

/// The sun is this far away: over 4 km its rays are parallel, and depth even, to 2 cm, and doubles hold places to a
/// ten thousandth of a millimetre.
constexpr double sun_m = 1e9;
/// What nothing is before.
constexpr float empty_texel = -std::numeric_limits<float>::infinity();

/// Depth reversed, along the map's axis: scale * z + shift, where z counts from the middle of the map or, for a local
/// light, from it and all is divided by z.
struct DepthRow {
    double scale, shift;
};
DepthRow depth_row(const ShadowView& view) {
    const double scale = view.clip_from_map[2][2], shift = view.clip_from_map[3][2];
    return view.is_local ? DepthRow{1.0 - scale, -shift} : DepthRow{-scale, 1.0 - shift};
}

/// What the light sees, as a picture of its own.
ViewTransform transform_of(const ShadowView& view) {
    const double half = 0.5 * view.side;
    const DepthRow depth = depth_row(view);
    ViewTransform made;
    made.optical_from_world = view.map_from_world;
    made.size = {shadow_stride(view.side), shadow_stride(view.side)};
    made.intrinsics.cx = made.intrinsics.cy = half - 0.5 + shadow_pad;
    if (view.is_local) {
        made.eye = view.origin;
        made.intrinsics.fx = half * view.clip_from_map[0][0];
        made.intrinsics.fy = half * view.clip_from_map[1][1];
        made.near_m = nearest_local_caster_m;
        made.depth_scale = depth.scale;
        made.depth_shift = depth.shift;
        return made;
    }
    made.eye = view.origin - sun_m * glm::transpose(view.map_from_world)[2];
    made.intrinsics.fx = sun_m * half * view.clip_from_map[0][0];
    made.intrinsics.fy = sun_m * half * view.clip_from_map[1][1];
    made.near_m = 0.5 * sun_m;  // whatever is before the near plane of the map casts too
    // Through the middle of the map, where it falls as the other does.
    made.depth_shift = -depth.scale * sun_m * sun_m;
    made.depth_scale = depth.shift - made.depth_shift / sun_m;
    return made;
}

PixelRect texels_of_tile(int side, int column, int row, int around) {
    const auto inside = [side](int at) { return std::clamp(at, 0, shadow_stride(side)); };
    return {inside((column * shadow_tile) - around), inside((row * shadow_tile) - around),
            inside((column + 1) * shadow_tile + around), inside((row + 1) * shadow_tile + around)};
}

}  // namespace

void SoftwareShadows::plan(const scene::PlacedScene& scene) {
    std::vector<WorldBox> boxes = shadow_receivers(scene);
    const std::vector<WorldBox> catchers = shadow_catchers(scene);
    // Where there is a scene, its maps are the same whatever backdrops there are.
    const std::vector<ShadowView> views = plan_shadows(scene.lights(), scene.environment().exposure,
                                                       boxes.empty() ? catchers : boxes, !scene.has_baked_light());
    boxes.insert(boxes.end(), catchers.begin(), catchers.end());
    if (!boxes.empty()) receivers_ = joined(boxes);
    if (!maps_.empty() && !views.empty() && maps_.front().view.side != views.front().side) maps_.clear();
    while (maps_.size() > views.size()) maps_.pop_back();
    while (maps_.size() < views.size()) {
        constexpr std::size_t alignment = lane_count * sizeof(float);
        const std::size_t bytes = 2 * shadow_texels_of_map(views.front().side) * sizeof(float);
        Map& map = maps_.emplace_back();
        map.memory = std::make_unique_for_overwrite<std::byte[]>(bytes + alignment);
        void* first = map.memory.get();
        std::size_t space = bytes + alignment;
        map.texels = static_cast<float*>(std::align(alignment, bytes, first, space));
    }
    for (std::size_t i = 0; i < views.size(); ++i) {
        maps_[i].view = views[i];
        maps_[i].transform = transform_of(views[i]);
    }
}

void SoftwareShadows::add_casters(Map& map, const scene::PlacedScene& scene, const Primitives& primitives,
                                  bool of_statics, double max_error_m, bool wide_lanes) const {
    scene::SceneView view{.scene = &scene, .transform = map.transform, .frustum = {}};
    map.geometry.begin_shadow_map(view, wide_lanes);
    for (const scene::PlacedSurface& surface : scene.group_of(of_statics).all()) {
        if (!casts_shadow(surface)) continue;
        const glm::dmat4 map_from_local = map.view.map_from(surface.world_from_local);
        if (!may_be_visible(map.view.frustum, map_from_local, surface.bounds.min, surface.bounds.max)) continue;
        const scene::SeenSurface seen{.placed = &surface,
                                      .is_static = of_statics,
                                      .level = shadow_level(surface, max_error_m),
                                      .optical_from_local = map.transform.optical_from(surface.world_from_local)};
        map.geometry.add(seen, *(of_statics ? primitives.statics : primitives.movers)[surface.index]);
    }
}

void SoftwareShadows::mark_movers(Map& map) const {
    const int side = map.view.side, tiles = shadow_tiles(side);
    map.movers.assign(static_cast<std::size_t>(tiles * tiles), 0);
    for (const WorldBox& caster : casters_) {
        const auto rect = shadow_texels(map.view, caster);
        if (!rect) continue;
        for (int row = (rect->y0 + shadow_pad) / shadow_tile; row <= (rect->y1 - 1 + shadow_pad) / shadow_tile; ++row) {
            const int first = (rect->x0 + shadow_pad) / shadow_tile, last = (rect->x1 - 1 + shadow_pad) / shadow_tile;
            std::fill_n(map.movers.begin() + row * tiles + first, last - first + 1,
                        static_cast<std::int32_t>(shadow_texels_of_map(side)));
        }
    }
    // The filter reaches into the tiles beside.
    static_assert(shadow_filter_texels <= shadow_pad);
    for (int row = 0; row < tiles; ++row) {
        for (int column = 0; column < tiles; ++column) {
            if (map.movers[static_cast<std::size_t>(row * tiles + column)] != 0)
                copy(still(map), moving(map), texels_of_tile(side, column, row, shadow_pad));
        }
    }
}

void SoftwareShadows::find_bounds(Map& map) {
    const int side = map.view.side, tiles = shadow_tiles(side);
    map.bounds.clear();
    map.bounds.reserve(static_cast<std::size_t>(tiles * tiles));
    constexpr int around = std::max(shadow_filter_before, shadow_filter_behind);
    for (int row = 0; row < tiles; ++row) {
        for (int column = 0; column < tiles; ++column) {
            const PixelRect rect = texels_of_tile(side, column, row, around);
            ShadowBounds& made = map.bounds.emplace_back(still(map)(rect.y0)[rect.x0], still(map)(rect.y0)[rect.x0]);
            for (int y = rect.y0; y < rect.y1; ++y) {
                const float* const texels = still(map)(y);
                const auto [least, most] = std::minmax_element(texels + rect.x0, texels + rect.x1);
                made = {std::min(made.least, *least), std::max(made.most, *most)};
            }
        }
    }
}

void SoftwareShadows::update(scene::PlacedScene& scene, const Primitives& primitives, ThreadTeam& team,
                             std::atomic<TimeNs>& cpu_ns, bool wide_lanes, bool has_detail_levels) {
    const auto run = [&](std::size_t count, const auto& work) {
        team.run(count, [&](int, std::size_t i) {
            const CpuMeter meter(cpu_ns);
            work(i);
        });
    };
    bool is_new = false;
    if (scene.statics_number() != statics_number_ || scene.proxies_number() != proxies_number_) {
        std::vector<ShadowView> before;
        for (const Map& map : maps_) before.push_back(map.view);
        statics_number_ = scene.statics_number();
        proxies_number_ = scene.proxies_number();
        plan(scene);
        // A light that only flickers changes no shadow.
        is_new = scene.objects_number() != objects_number_ || !std::ranges::equal(maps_, before, {}, &Map::view);
        objects_number_ = scene.objects_number();
    }
    find_moving_casters(scene, casters_);
    if (maps_.empty()) return;

    const auto bands = static_cast<std::size_t>(team.size());
    const auto draw = [&](const auto& layer) {
        run(maps_.size() * bands, [&](std::size_t i) {
            const Map& map = maps_[i / bands];
            const int side = map.view.side;
            const auto row = [&](std::size_t band) {
                return shadow_pad + static_cast<int>(band * static_cast<std::size_t>(side) / bands);
            };
            const PixelRect band{shadow_pad, row(i % bands), shadow_pad + side, row(i % bands + 1)};
            draw_depth(map.geometry, band, layer(map));
        });
    };
    if (is_new) {
        run(maps_.size(), [&](std::size_t i) {
            std::fill_n(maps_[i].texels, shadow_texels_of_map(maps_[i].view.side), empty_texel);
            add_casters(maps_[i], scene, primitives, true, 0.0, wide_lanes);
        });
        draw(still);
        run(maps_.size(), [&](std::size_t i) { find_bounds(maps_[i]); });
        for (Map& map : maps_) map.geometry = {};  // of a large scene, more than the maps
    }
    const auto error_of = [&](const Map& map) { return has_detail_levels ? 0.5 * map.view.texel_m : 0.0; };
    const std::span<const scene::PlacedSurface> movers = scene.movers().all();
    run(movers.size(), [&](std::size_t i) {
        const scene::PlacedSurface& surface = movers[i];
        if (surface.deformation < 0 || !casts_shadow(surface)) return;
        scene::LevelSet levels = 0;
        for (const Map& map : maps_) {
            const glm::dmat4 map_from_local = map.view.map_from(surface.world_from_local);
            if (may_be_visible(map.view.frustum, map_from_local, surface.bounds.min, surface.bounds.max))
                levels |= scene::LevelSet{1} << shadow_level(surface, error_of(map));
        }
        if (levels != 0) scene.movers().deform(surface, levels);
    });
    run(maps_.size(), [&](std::size_t i) {
        mark_movers(maps_[i]);
        add_casters(maps_[i], scene, primitives, false, error_of(maps_[i]), wide_lanes);
    });
    draw(moving);
}

std::vector<ShadowInView> SoftwareShadows::in_view(const ViewTransform& t) const {
    std::vector<ShadowInView> made;
    for (const Map& map : maps_) {
        const ShadowView& view = map.view;
        glm::dmat4 map_from_optical(view.map_from_world * glm::transpose(t.optical_from_world));
        map_from_optical[3] = glm::dvec4(view.map_from_world * (t.eye - view.origin), 1.0);
        const glm::dmat4 rows = glm::transpose(map_from_optical);  // x, y and z in the map, and 1
        const glm::dvec4 w = view.is_local ? rows[2] : rows[3];
        const auto across = [&](int axis) {
            return 0.5 * view.side * (view.clip_from_map[axis][axis] * rows[axis] + w) + double{shadow_pad} * w;
        };
        const DepthRow depth = depth_row(view);
        ShadowInView& in = made.emplace_back();
        in.light = view.light;
        in.side = view.side;
        const std::array<glm::dvec4, 4> place{across(0), across(1), depth.scale * rows[2] + depth.shift * rows[3], w};
        in.rows = {glm::vec4(place[0]), glm::vec4(place[1]), glm::vec4(place[2]), glm::vec4(place[3])};
        in.planes = plane_rows(place);
        in.texel_m = static_cast<float>(view.texel_m);
        in.texel_per_m = static_cast<float>(view.texel_per_m);
        in.texels = map.texels;
        in.movers = map.movers.data();
        in.bounds = map.bounds.data();
    }
    return made;
}

void SoftwareShadows::find_changed_pixels(const scene::SceneView& view, const PixelRect& whole,
                                          std::vector<PixelRect>& to) const {
    if (view.lens != nullptr) {
        if (!maps_.empty() && !casters_.empty()) to.push_back(whole);
        return;
    }
    for (const Map& map : maps_) {
        for (const WorldBox& caster : casters_) {
            if (const auto rect = shadow_pixels(view.transform, map.view, caster, receivers_)) to.push_back(*rect);
        }
    }
}

}  // namespace camrig::render::software
