#pragma once

#include <array>
#include <atomic>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "core/base/tile_set.h"
#include "core/render/renderer.h"
#include "core/render/shown_picture.h"
#include "core/render/software/area_work.h"
#include "core/render/software/asked_pictures.h"
#include "core/render/software/flow.h"
#include "core/render/software/rasterizer.h"
#include "core/render/software/shadowed_statics.h"
#include "core/render/view_motion.h"

/// What is known of a view from instant to instant, and while it is drawn.
namespace camrig::render::software {

/// A picture that is kept: its codes or, of a camera with a sensor, its light.
struct KeptPicture {
    Plane<std::uint32_t> color;
    std::array<Plane<float>, 3> light;

    KeptPicture() = default;
    KeptPicture(ImageSize size, bool is_light) {
        if (!is_light) color = Plane<std::uint32_t>(size);
        for (Plane<float>& plane : light)
            if (is_light) plane = Plane<float>(size);
    }
    static std::int64_t bytes_for(ImageSize size, bool is_light) {
        return (is_light ? 3 : 1) * Plane<float>::bytes_for(size);
    }
    explicit operator bool() const { return color || light[0]; }
    Canvas canvas() const { return {color.rows(), {}, light_rows(light)}; }
};

/// What is kept of a camera that stands still.
struct StaticLayer {
    Plane<float> depth;
    /// What is opaque; empty: nobody asked for colour yet. Of a film: alpha is 0 where its pictures show.
    KeptPicture picture;
    KeptPicture finished;  ///< empty: nothing is blended, it is `picture`
    const KeptPicture& shown() const { return finished ? finished : picture; }
    bool is_blended = false;                    ///< of a film: something is blended over all that stands still
    StaticAreas areas;                          ///< of pictures of exact areas, with `picture`
    std::unique_ptr<ShadowedStatics> shadowed;  ///< with `picture`, where there are shadows
    Rows<float> depth_of_shadowed() const { return shadowed->depth ? shadowed->depth.rows() : depth.rows(); }
    sensor::SiteLight sites;  ///< of the finished picture, for the sensor that asked last
    /// By kind, as their frames are; empty: nobody asked for it yet.
    std::array<Plane<std::uint32_t>, frame::frame_kind_count> channels;
    std::map<ObjectId, frame::Silhouette> silhouettes;  ///< of static objects whose were asked for
    std::uint64_t number = 0;  ///< no two that were ever kept have the same; 0: nothing is kept yet
};

/// What a frame showed: a layer, and other things in some rectangles.
struct ShownFrame {
    std::uint64_t mark = 0;   ///< Frame::content_mark; 0: none
    std::uint64_t layer = 0;  ///< 0: none that is kept
    std::vector<PixelRect> rects;
};

/// The last frames of a camera: of each kind, in a ring.
struct FrameHistory {
    struct OfKind {
        std::array<ShownFrame, 8> frames;
        std::size_t last = 0;
    };
    std::array<OfKind, frame::frame_kind_count> kinds;
    ShownPicture picture;  ///< of colour
    /// Of a film: the layer and the picture that were shown last, and the number of both together.
    std::uint64_t film_layer = 0, film_below = 0;
    std::int64_t film_frame = -1;
};

/// A picture of a view that is no colour (channels.h).
struct ChannelFrame {
    std::shared_ptr<frame::Frame> frame;  ///< null: not wanted
    std::span<const PixelRect> stale;     ///< if a layer is kept: where the frame's memory holds something else
};

struct ViewWork {
    const View* view = nullptr;
    KindSet kinds;  ///< that are drawn
    bool wants_flow = false;
    AskedPictures::OfCamera* asked = nullptr;  ///< null: what is drawn is not kept
    scene::SceneView scene;
    std::shared_ptr<const LensRays> rays;  ///< of the scene's lens
    StaticLayer* layer = nullptr;
    FrameHistory* history = nullptr;
    scene::SeenMovers movers;
    const world::Backdrop* backdrop = nullptr;       ///< null: none
    std::shared_ptr<const world::Image> picture;     ///< of the backdrop, if colour is drawn
    std::int64_t film_frame = -1;                    ///< which of a film it is; -1: it is none
    std::uint64_t below = 0;                         ///< what lies below what moves: never the same for two pictures
    const scene::PlacedSurfaces* proxies = nullptr;  ///< of the backdrop, beside those of the scene; null: none
    PixelRect whole;
    std::vector<PixelRect> rects;      ///< what is drawn: where movers are, if a layer is kept
    std::span<const PixelRect> stale;  ///< if a layer is kept: where the frame's memory holds something else
    std::atomic<int> bands_left = 0;
    std::shared_ptr<frame::Frame> frame;                         ///< of colour; null: not wanted
    std::array<ChannelFrame, frame::frame_kind_count> channels;  ///< by kind
    Canvas canvas;
    std::optional<sensor::Exposure> exposure;  ///< of a camera with a sensor
    std::span<std::uint16_t> numbers;          ///< of that sensor: of its frame or in scratch memory
    bool has_sites = false;                    ///< light of what stands still is the layer's, gathered
    TileSet drawn_tiles;                       ///< then: where the canvas' light is looked at
    std::vector<PixelRect> new_tiles;          ///< of those, marked last: they hold nothing yet
    bool keeps_sites = false;                  ///< it is gathered with this picture
    bool is_in_frame = false;                  ///< the canvas' colour is the frame's; false: it is copied there
    bool is_in_parts = false;
    bool has_areas = false;             ///< Antialias::coverage
    std::optional<ViewMotion> motion;   ///< while it is taken; nullopt: the view is drawn as of its instant
    bool is_moment = false;             ///< of such a view: it is drawn in the rectangles alone
    SceneAhead* ahead = nullptr;        ///< of a moment whose flow is drawn
    bool is_light = false;              ///< of a moment: light is drawn, no frame
    std::vector<ShadowInView> shadows;  ///< of a colour picture of quality beautiful
    scene::BodiesInView bodies;         ///< if the scene has contact occlusion
    std::uint64_t draws = 0, draws_coarse = 0;
    std::atomic<TimeNs> cost_ns = 0;  ///< CPU time of all threads

    bool has_film() const { return film_frame >= 0; }
    /// A sensor makes the colour picture.
    bool takes_picture() const { return exposure && frame != nullptr; }
    /// What moves may change how what stands still looks beside it.
    bool movers_darken() const { return !shadows.empty() || scene.has_contact_occlusion; }
    bool is_shaded() const { return is_light || frame != nullptr; }
    /// Of a view with motion: world and camera as they were.
    world::CameraPast::Moment moment_at(TimeNs world_ns) const {
        return view->past ? view->past->at(world_ns) : motion->moments[1];
    }
};

struct TriangleRange {
    std::uint32_t first = 0, count = 0;
    std::uint32_t end() const { return first + count; }
};

/// What it takes to draw a view.
struct ViewScratch {
    ViewGeometry geometry;
    TriangleRange statics, movers;                             ///< opaque
    std::uint32_t catchers = 0;                                ///< so many of the first triangles, before `statics`
    std::uint32_t proxies = 0;                                 ///< so many, with them and the first of `statics`
    std::vector<ViewDraw> blended_statics, blended;            ///< from far to near; the second with the first
    std::vector<scene::SeenSurface> opaque, blending;          ///< static ones, as they are seen
    std::vector<const SoftwarePrimitive*> proxy_primitives;    ///< of ViewWork::proxies
    std::vector<std::int32_t> ids_of_draws, classes_of_draws;  ///< by draw, for channels
    TriangleNumbers numbers;
    Plane<float> depth;
    TriangleNumbers receivers;    ///< where there are catchers (find_receivers)
    Plane<float> receiver_depth;  ///< of these
    AreaScratch areas;
    Plane<std::uint32_t> below, actors, actor_colors;  ///< of what is matched to a photo (matched_actors.h)
    Plane<std::uint32_t> color;                        ///< of pictures whose rows are no whole groups of lanes
    std::array<Plane<float>, 3> light;                 ///< of cameras with a sensor
    std::vector<std::uint16_t> sensor_numbers;         ///< of those whose numbers nobody asked for
};

/// Of views that are taken while something moves: light before a sensor.
struct ExposureScratch {
    std::array<Plane<float>, 3> sum;       ///< of all moments so far
    std::array<Plane<float>, 3> moment;    ///< of one
    std::array<Plane<float>, 3> standing;  ///< what stands still
    std::vector<std::uint16_t> numbers;    ///< as ViewScratch::sensor_numbers
};

inline Rows<std::uint32_t> rows_of(frame::Frame& frame) {
    return {reinterpret_cast<std::uint32_t*>(frame.mutable_bytes().data()), frame.info().size.width};
}

}  // namespace camrig::render::software
