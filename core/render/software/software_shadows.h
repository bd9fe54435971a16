#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <span>
#include <vector>

#include "core/render/software/geometry.h"
#include "core/render/software/thread_team.h"

namespace camrig::render::software {

/// The shadow maps of one instant, shared by all views (shadow_plan.h).
///
/// Two layers of depth for each light: of what stands still, drawn when that or the light changes; and, only in tiles
/// where movers may be in the way, of everything, made anew each instant. Where no mover is in the way a look-up reads
/// the same texels with and without movers: the static layers of cameras live on that.
class SoftwareShadows {
public:
    /// What the triangles of placed surfaces come from.
    struct Primitives {
        std::span<const SoftwarePrimitive* const> statics, movers;
    };

    /// Draws what has changed; made when a picture with shadows is drawn. cpu_ns: the time of all threads is added.
    /// has_detail_levels: movers far from having texels of their own may be coarser.
    void update(scene::PlacedScene& scene, const Primitives& primitives, ThreadTeam& team, std::atomic<TimeNs>& cpu_ns,
                bool wide_lanes, bool has_detail_levels);

    bool empty() const { return maps_.empty(); }
    /// As a view of the scene looks them up, until the next update.
    std::vector<ShadowInView> in_view(const ViewTransform& view) const;
    /// Appends rectangles that hold every pixel of a view whose light movers may be in the way of; through a lens,
    /// whose pictures of long shadows are not bounded, all of it.
    void find_changed_pixels(const scene::SceneView& view, const PixelRect& whole, std::vector<PixelRect>& to) const;

private:
    struct Map {
        ShadowView view;
        ViewTransform transform;
        std::unique_ptr<std::byte[]> memory;  ///< of both layers; what nobody writes takes none
        float* texels = nullptr;              ///< in it
        std::vector<std::int32_t> movers;     ///< by tile, as ShadowInView::movers
        std::vector<ShadowBounds> bounds;     ///< by tile
        ViewGeometry geometry;
    };
    void plan(const scene::PlacedScene& scene);
    void add_casters(Map& map, const scene::PlacedScene& scene, const Primitives& primitives, bool of_statics,
                     double max_error_m, bool wide_lanes) const;
    void mark_movers(Map& map) const;
    static void find_bounds(Map& map);
    static Rows<float> still(const Map& map) { return {map.texels, shadow_stride(map.view.side)}; }
    static Rows<float> moving(const Map& map) {
        return {map.texels + shadow_texels_of_map(map.view.side), shadow_stride(map.view.side)};
    }

    std::uint64_t statics_number_ = 0, objects_number_ = 0, proxies_number_ = 0;
    std::deque<Map> maps_;
    WorldBox receivers_;
    std::vector<WorldBox> casters_;  ///< the movers
};

}  // namespace camrig::render::software
