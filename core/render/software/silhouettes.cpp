#include <bit>
#include <unordered_map>

#include "core/render/software/rasterizer.h"
#include "core/render/software/rows.h"
#include "core/render/software/software_drawer.h"
#include "core/render/software/view_rows.h"

namespace camrig::render::software {
namespace {

/// The runs of what has a number, which is none any more afterwards.
void take_runs(Rows<std::uint32_t> numbers, const PixelRect& rect, frame::Silhouette& to) {
    for (int y = rect.y0; y < rect.y1; ++y) {
        std::uint32_t* const row = numbers(y);
        for (int x = rect.x0; x < rect.x1;) {
            while (x < rect.x1 && row[x] == 0) ++x;
            const int begin = x;
            while (x < rect.x1 && row[x] != 0) row[x++] = 0;
            if (x > begin) to.push_back({y, begin, x});
        }
    }
}

}  // namespace

std::vector<frame::Silhouette> SoftwareDrawer::silhouettes(const View& view, std::span<const ObjectId> objects) {
    struct Unknown {
        std::size_t index = 0;  ///< among the objects
        std::vector<scene::SeenSurface> surfaces;
    };
    const scene::SceneView scene = scene_view_of(view, world::Quality::simple);
    const std::shared_ptr<const LensRays> rays = lens_of(view)->rays;
    // Where it stands, what stands still shows the same pixels in every picture.
    StaticLayer* layer = layers_.layer_of(view, scene);
    if (layer != nullptr && layer->number == 0) layer = nullptr;
    std::vector<frame::Silhouette> made(objects.size());
    std::vector<Unknown> unknown;
    std::unordered_map<std::uint32_t, std::size_t> place_of;
    for (std::size_t i = 0; i < objects.size(); ++i) {
        if (layer != nullptr) {
            const auto kept = layer->silhouettes.find(objects[i]);
            if (kept != layer->silhouettes.end()) {
                made[i] = kept->second;
                continue;
            }
        }
        place_of.emplace(static_cast<std::uint32_t>(objects[i]), unknown.size());
        unknown.push_back({.index = i, .surfaces = {}});
    }
    const auto& backdrop = view.spec->backdrop;
    for (const bool of_statics : {true, false}) {
        if (of_statics && backdrop && backdrop->proxies.scene == world::SceneInBackdrop::hidden) continue;
        for (const scene::PlacedSurface& surface : scene_.group_of(of_statics).all()) {
            if (surface.primitive->is_blended) continue;
            const auto found = place_of.find(static_cast<std::uint32_t>(surface.object->id));
            if (found == place_of.end()) continue;
            if (const auto seen = scene.see(surface, of_statics)) unknown[found->second].surfaces.push_back(*seen);
        }
    }
    const ImageSize size = view.spec->size;
    team_.run(unknown.size(), [&](int worker, std::size_t i) {
        const Unknown& of = unknown[i];
        ViewScratch& scratch = scratch_[static_cast<std::size_t>(worker)];
        scratch.numbers.fit(size);
        scratch.depth.fit(size);
        scratch.geometry.begin_view(scene, rays, options_.wide_lanes);
        std::vector<PixelRect> touched;
        for (const scene::SeenSurface& seen : of.surfaces) {
            const auto pixels = scene.pixels_of(seen);
            if (!pixels) continue;
            touched.push_back(*pixels);
            if (seen.placed->deformation >= 0 && !seen.is_static)
                scene_.movers().deform(*seen.placed, scene::LevelSet{1} << seen.level);
            const auto& primitives = seen.is_static ? static_primitives_ : mover_primitives_;
            scratch.geometry.add(seen, *primitives[seen.placed->index]);
        }
        if (touched.empty()) return;
        const PixelRect rect = hull_of(touched);
        const Canvas canvas{{}, scratch.depth.rows(), {}};
        fill(canvas.depth, rect, 0.0f);
        cover_blind(scene, canvas, rect);
        find_visible(scratch.geometry, 0, static_cast<std::uint32_t>(scratch.geometry.triangles().size()), rect, canvas,
                     scratch.numbers);
        take_runs(scratch.numbers.rows(), rect, made[of.index]);
    });
    if (layer == nullptr) return made;
    for (const Unknown& of : unknown) {
        if (of.surfaces.empty() || !of.surfaces.front().is_static) continue;
        if (!layers_.keep_silhouette(*layer, objects[of.index], made[of.index])) break;
    }
    return made;
}

}  // namespace camrig::render::software
