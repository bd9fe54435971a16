#include <algorithm>
#include <cmath>

#include "core/render/aperture.h"
#include "core/render/software/channels.h"
#include "core/render/software/matched_actors.h"
#include "core/render/software/rows.h"
#include "core/render/software/screen_triangles.h"
#include "core/render/software/software_drawer.h"
#include "core/render/software/taken_picture.h"
#include "core/render/software/view_changes.h"
#include "core/render/view_frames.h"

// What a view needs before its rows are drawn: which kinds, by which layer, into which frames, of which triangles.
namespace camrig::render::software {
namespace {

/// Triangles are cut guard_px - |c| beside the principal point c: no edge of the picture may be farther from it.
bool is_within_reach(double principal_point, int side) {
    return std::max(std::abs(principal_point), std::abs(side - principal_point)) <=
           guard_px - std::abs(principal_point);
}

bool has_all_that_is_asked_for(const StaticLayer& layer, const ViewWork& work) {
    if (layer.number == 0 || (work.is_shaded() && !layer.picture)) return false;
    return std::ranges::all_of(channel_kinds, [&](frame::FrameKind kind) {
        const auto k = index_of(kind);
        return work.channels[k].frame == nullptr || layer.channels[k];
    });
}

}  // namespace

bool SoftwareDrawer::has_areas(const View& view) {
    return antialias_of(*view.spec, view.quality) == world::Antialias::coverage;
}

bool SoftwareDrawer::may_draw(const View& view, frame::FrameKind kind) {
    const world::CameraSpec& spec = *view.spec;
    if (!is_within_reach(spec.intrinsics.cx, spec.size.width) || !is_within_reach(spec.intrinsics.cy, spec.size.height))
        return false;
    const bool is_pinhole = spec.lens.model == camera::LensModel::pinhole;
    if (kind == frame::FrameKind::sensor && !spec.sensor) return false;
    if (kind == frame::FrameKind::flow && view.future == nullptr) return false;
    if (kind != frame::FrameKind::color && kind != frame::FrameKind::sensor) return true;
    if (is_pinhole ? spec.lens_sampling.method != world::LensMethod::automatic
                   : spec.lens_sampling != world::LensSampling{})
        return false;
    return antialias_of(spec, view.quality) == world::Antialias::none || has_areas(view);
}

bool SoftwareDrawer::can_draw(const View& view, frame::FrameKind kind) {
    if (!may_draw(view, kind)) return false;
    return view.spec->lens.model == camera::LensModel::pinhole || lens_of(view).has_value();
}

scene::SceneView SoftwareDrawer::scene_view_of(const View& view, world::Quality quality) {
    const world::CameraSpec& spec = *view.spec;
    scene::SceneView made =
        make_scene_view(scene_, make_view_transform(view.pose, spec.size, spec.intrinsics, spec.near_m, spec.far_m),
                        spec.far_m, quality, options_.max_detail_error_px, lens_of(view)->view);
    made.exposure_gain = scene::exposure_gain_of(spec);
    return made;
}

KindSet SoftwareDrawer::kinds_to_draw(const View& view, ViewWork& work) {
    const auto can = [&](frame::FrameKind kind) { return can_draw(view, kind); };
    KindSet wanted;
    for (std::size_t k = 0; k < wanted.size(); ++k) wanted[k] = view.kinds[k] && can(static_cast<frame::FrameKind>(k));
    // What comes may be another future with each question: flow is not kept.
    work.wants_flow = wanted[index_of(frame::FrameKind::flow)];
    wanted.reset(index_of(frame::FrameKind::flow));
    KindSet drawn = asked_.to_draw(view, wanted, can, work.asked);
    // Numbers are made on the way to the picture.
    if (drawn[index_of(frame::FrameKind::sensor)]) drawn.set(index_of(frame::FrameKind::color));
    return drawn;
}

void SoftwareDrawer::prepare(const View& view, ViewWork& work) {
    work.view = &view;
    work.backdrop = view.spec->backdrop_here.get();
    work.proxies = scene_.proxies_of(view.spec->backdrop_here);
    work.picture = nullptr;
    work.film_frame = -1;
    const bool is_shaded = work.kinds[index_of(frame::FrameKind::color)];
    work.scene = scene_view_of(view, is_shaded ? view.quality : world::Quality::simple);
    if (work.backdrop != nullptr && !work.backdrop->is_sampled() && is_shaded) take_picture_of_backdrop(work);
    if (view.spec->backdrop) {
        work.scene.light_gain = glm::vec3(view.spec->backdrop->plate_gain);
        work.scene.has_contact_shadows = view.spec->backdrop->shadow != world::BackdropShadow::none;
        // A photo has its light and its air in it.
        work.scene.has_contact_occlusion = work.scene.has_fog = false;
    }
    // A sensor has a curve of its own, and a photo had its.
    work.scene.has_tone_curve = work.scene.quality == world::Quality::beautiful && scene_.environment().daylight &&
                                !view.spec->sensor && !view.spec->backdrop;
    work.rays = lens_of(view)->rays;
    work.exposure = exposure_of(view, *scene_.snapshot()).value();
    work.motion = work.exposure ? motion_of(view, work.exposure->times) : std::nullopt;
    if (work.exposure && is_shaded && !work.motion && aperture_of(*view.spec))
        work.motion = standing_still(view, work.exposure->times, scene_.snapshot());
    // Chosen objects are another picture than the one that is kept.
    work.layer = view.only_objects.empty() ? layers_.layer_of(view, work.scene) : nullptr;
    // What shows in parts of pixels is kept with its colour.
    if (work.has_film() && has_areas(view)) work.layer = nullptr;
    work.history = &histories_[view.camera];
    work.draws = work.draws_coarse = 0;
    work.movers.see(work.scene);
}

void SoftwareDrawer::take_picture_of_backdrop(ViewWork& work) {
    const View& view = *work.view;
    world::FilmShot shot;
    if (work.backdrop->film != nullptr) {
        shot = view.film ? *view.film : work.backdrop->film->at(instant_ns_, true);
        work.film_frame = shot.frame;
    }
    work.picture = work.backdrop->picture(shot);
}

void SoftwareDrawer::acquire_frames(ViewWork& work, TimeNs monotonic_ns) {
    const View& view = *work.view;
    for (int k = 0; k < frame::frame_kind_count; ++k) {
        const auto kind = static_cast<frame::FrameKind>(k);
        auto& frame = kind == frame::FrameKind::color ? work.frame : work.channels[static_cast<std::size_t>(k)].frame;
        frame.reset();
        if (work.kinds[static_cast<std::size_t>(k)])
            frame = acquire_frame(
                *options_.pool, view, kind,
                kind == frame::FrameKind::sensor ? raw_format(view.spec->sensor->filter) : format_of(kind), instant_ns_,
                monotonic_ns, work.exposure);
    }
}

void SoftwareDrawer::begin_view(ViewWork& work, ViewScratch& scratch, int bands, TimeNs monotonic_ns) {
    const View& view = *work.view;
    const ImageSize size = view.spec->size;
    work.whole = {0, 0, size.width, size.height};
    work.bands_left = bands;
    work.is_in_frame = size.width % lane_count == 0;
    scratch.numbers.fit(size);
    scratch.depth.fit(size);
    acquire_frames(work, monotonic_ns);
    work.has_areas = work.frame != nullptr && has_areas(view);
    work.canvas = {{}, scratch.depth.rows(), {}};
    if (work.takes_picture()) {
        begin_taking(work, scratch.light, scratch.sensor_numbers);
    } else if (work.frame != nullptr) {
        if (!work.is_in_frame) scratch.color.fit(size);
        work.canvas.color = work.is_in_frame ? rows_of(*work.frame) : scratch.color.rows();
    }
    if (is_matched(work))
        for (Plane<std::uint32_t>* const plane : {&scratch.below, &scratch.actors, &scratch.actor_colors})
            plane->fit(size);
    work.is_in_parts = work.layer != nullptr && has_all_that_is_asked_for(*work.layer, work);
    if (work.is_in_parts) {
        find_changes(work, shadows_);
    } else {
        work.rects.assign(1, work.whole);
        if (work.frame != nullptr) work.history->picture.next(view.sequence, {});
    }
    begin_drawing(work, scratch, bands);
    layers_.keep_sites(work);
}

void SoftwareDrawer::begin_drawing(ViewWork& work, ViewScratch& scratch, int bands) {
    add_triangles(work, scratch);
    if (work.scene.has_contact_occlusion) {
        scratch.geometry.set_bodies(work.bodies);
        if (work.is_in_parts && work.layer->shadowed != nullptr) work.layer->shadowed->geometry.set_bodies(work.bodies);
    }
    if (work.has_areas) scratch.areas.begin(work.view->spec->size, bands);
    if (scratch.catchers > 0) {
        scratch.receivers.fit(work.view->spec->size);
        scratch.receiver_depth.fit(work.view->spec->size);
    }
    name_draws(scratch);
    if (work.layer != nullptr && !work.is_in_parts)
        layers_.make(work, !scratch.blended_statics.empty(), scratch.catchers > 0);
    // Nobody keeps the statics alone: what movers hide of them is not shaded.
    const bool has_picture = work.backdrop != nullptr && work.is_shaded();
    if (work.layer == nullptr && !work.has_areas && !has_picture)
        scratch.movers = {scratch.statics.first, scratch.statics.count + scratch.movers.count};
}

}  // namespace camrig::render::software
