#pragma once

#include <memory>
#include <mutex>

#include "core/render/layer_table.h"
#include "core/render/scene/seen_statics.h"
#include "core/render/software/handed_layers.h"
#include "core/render/software/view_work.h"

namespace camrig::render::software {

/// Of a layer, or of what a frame holds: never the same twice, whoever asks.
std::uint64_t next_content_number();

/// What a drawer keeps of cameras that stand still (StaticLayer): makes it with a picture that is drawn in full, fills
/// it with what was drawn, and says what memory it takes. Where there is no room the view goes on without a layer.
///
/// Thread: the drawer's. make() and keep_..() of several views may be called at once.
class StaticLayers {
public:
    /// What one drawer hands over, another one takes of `handed`.
    StaticLayers(std::int64_t max_bytes, std::shared_ptr<HandedLayers> handed)
        : max_bytes_(max_bytes), handed_(std::move(handed)), table_(max_bytes) {}

    void next_instant() { table_.next_instant(); }
    /// As LayerTable::layer_of.
    StaticLayer* layer_of(const View& view, const scene::SceneView& scene);
    /// Room for what the view's picture will show, if its layer has none of that yet.
    void make(ViewWork& work, bool has_blended, bool has_catchers);
    /// Of a picture whose layer is new: its edges, and the geometry that drew it, whose sizes only the picture tells.
    void keep_what_was_drawn(ViewWork& work, ViewScratch& scratch);
    /// Gathered light of the view's layer, for its sensor, if there is room.
    void keep_sites(ViewWork& work);
    /// An outline that was asked for; false: there is no room.
    bool keep_silhouette(StaticLayer& layer, ObjectId object, const frame::Silhouette& runs);
    void count_reused() { table_.count_reused(); }

    void forget(CameraId camera);
    /// Another drawer draws the camera of this scene from now on: its layer is left for that one.
    void hand_over(CameraId camera, const scene::PlacedScene& scene);
    void clear();
    RenderCounters counters() const { return table_.counters(); }

private:
    void take_handed(const View& view, const scene::SceneView& scene, const StaticLayerKey& key);
    void keep_areas(ViewWork& work, const ViewScratch& scratch);
    void keep_shadowed(ViewWork& work, ViewScratch& scratch);
    void charge_for(ViewWork& work, std::int64_t bytes);

    const std::int64_t max_bytes_;
    const std::shared_ptr<HandedLayers> handed_;
    scene::SeenStatics seen_;
    LayerTable<StaticLayer> table_;
    std::mutex mutex_;  ///< of the table while views are drawn
};

}  // namespace camrig::render::software
