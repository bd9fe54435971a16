#include <algorithm>
#include <span>

#include "core/render/software/baked_picture.h"
#include "core/render/software/software_drawer.h"

// Which triangles of what a view sees are drawn, in which order: statics, movers, what is blended.
namespace camrig::render::software {
namespace {

void keep_only(std::span<const ObjectId> objects, std::vector<scene::SeenSurface>& surfaces) {
    if (objects.empty()) return;
    std::erase_if(surfaces, [&](const scene::SeenSurface& seen) {
        return std::ranges::find(objects, seen.placed->object->id) == objects.end();
    });
}

std::uint32_t triangles_in(const ViewGeometry& geometry) {
    return static_cast<std::uint32_t>(geometry.triangles().size());
}

}  // namespace

void SoftwareDrawer::add_triangles(ViewWork& work, ViewScratch& scratch) {
    const auto add = [&](const scene::SeenSurface& seen) -> const ViewDraw& {
        ++work.draws;
        work.draws_coarse += seen.level > 0;
        const auto& primitives = seen.is_static ? static_primitives_ : mover_primitives_;
        return scratch.geometry.add(seen, *primitives[seen.placed->index],
                                    work.ahead != nullptr ? work.ahead->positions_of(seen) : nullptr);
    };
    const auto count = [&] { return triangles_in(scratch.geometry); };
    const bool is_beautiful = work.scene.quality == world::Quality::beautiful;
    scratch.geometry.begin_view(
        work.scene, work.rays, options_.wide_lanes, work.has_areas, work.shadows,
        is_beautiful ? caches_.baked->of(*scene_.snapshot()->statics, work.scene.lamps_hz) : nullptr);
    scratch.opaque.clear();
    scratch.blending.clear();
    scratch.catchers = scratch.proxies = 0;
    const bool is_shaded = work.is_shaded();
    work.scene.see_all(true, work.is_in_parts ? nullptr : &scratch.opaque, is_shaded ? &scratch.blending : nullptr);
    if (work.backdrop != nullptr) add_proxies(work, scratch);
    keep_only(work.view->only_objects, scratch.opaque);
    keep_only(work.view->only_objects, work.movers.opaque);
    if (work.is_moment) {
        for (auto* const list : {&scratch.opaque, &scratch.blending, &work.movers.opaque, &work.movers.blended})
            std::erase_if(*list, [&](const scene::SeenSurface& seen) { return !work.scene.touches(seen, work.rects); });
    }
    if (work.is_in_parts)
        std::erase_if(scratch.blending,
                      [&](const scene::SeenSurface& seen) { return !work.scene.touches(seen, work.rects); });
    for (const scene::SeenSurface& seen : scratch.opaque) add(seen);
    scratch.statics = {scratch.catchers, count() - scratch.catchers};
    for (const scene::SeenSurface& seen : work.movers.opaque) add(seen);
    scratch.movers = {scratch.statics.end(), count() - scratch.statics.end()};
    scratch.blended_statics.clear();
    for (const scene::SeenSurface& seen : scratch.blending) scratch.blended_statics.push_back(add(seen));
    scratch.blended.assign(scratch.blended_statics.begin(), scratch.blended_statics.end());
    if (is_shaded) {
        for (const scene::SeenSurface& seen : work.movers.blended) scratch.blended.push_back(add(seen));
    }
    sort_far_to_near(scratch.blended_statics);
    sort_far_to_near(scratch.blended);
}

void SoftwareDrawer::add_proxies(ViewWork& work, ViewScratch& scratch) {
    const world::SceneInBackdrop role = work.view->spec->backdrop->proxies.scene;
    if (role != world::SceneInBackdrop::drawn) scratch.blending.clear();
    if (role == world::SceneInBackdrop::hidden) scratch.opaque.clear();
    if (work.is_in_parts) return;
    if (work.proxies != nullptr && work.view->only_objects.empty()) {
        find_primitives(*work.proxies, scratch.proxy_primitives);
        const auto catches_only = [&](const scene::PlacedSurface& surface) {
            return std::ranges::any_of(work.backdrop->catchers, [&](const world::Instance& catcher) {
                return catcher.info.get() == surface.object;
            });
        };
        for (const scene::PlacedSurface& surface : work.proxies->all()) {
            if (surface.primitive->is_blended) continue;
            const auto seen = work.scene.see(surface, true);
            if (!seen) continue;
            scratch.geometry.add(*seen, *scratch.proxy_primitives[surface.index]);
            // Those come first.
            if (catches_only(surface)) scratch.catchers = triangles_in(scratch.geometry);
        }
    }
    if (role == world::SceneInBackdrop::proxies && work.view->only_objects.empty()) {
        for (const scene::SeenSurface& seen : scratch.opaque)
            scratch.geometry.add(seen, *static_primitives_[seen.placed->index]);
        scratch.opaque.clear();
    }
    scratch.proxies = triangles_in(scratch.geometry);
}

}  // namespace camrig::render::software
