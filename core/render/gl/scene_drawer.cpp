#include "core/render/gl/scene_drawer.h"

#include <algorithm>

#include "core/frame/srgb.h"
#include "core/render/view_frames.h"

namespace camrig::render::gl {
namespace {

float code_of(float linear) {
    return static_cast<float>(frame::srgb_of_linear(std::clamp(linear, 0.0f, 1.0f)));
}

PixelRect scaled(const PixelRect& rect, int factor) {
    return {rect.x0 * factor, rect.y0 * factor, rect.x1 * factor, rect.y1 * factor};
}

glm::vec3 background_of(const View& view, const scene::PlacedScene& scene) {
    scene::SceneView seen;
    seen.scene = &scene;
    seen.exposure_gain = scene::exposure_gain_of(*view.spec);
    return seen.background();
}

/// Mesa 22.3 llvmpipe copies parts of multisampled pictures wrongly (StaticLayer tests fail); whole ones it can.
bool may_draw_parts(const ViewPlan& plan) {
    return plan.tiles.size() == 1 && plan.multisampling == 1;
}

}  // namespace

void SceneDrawer::begin_instant() {
    layers_.next_instant();
    lights_are_made_ = false;
}

void SceneDrawer::prepare(std::span<const View> views, GpuScene& scene) {
    state_is_ours_ = false;
    const auto is_lit = [](const View& view) {
        return view.quality == world::Quality::beautiful && wants(view, frame::FrameKind::color);
    };
    if (lights_are_made_ || std::ranges::none_of(views, is_lit)) return;
    lights_are_made_ = true;
    shadows_.update(scene, pass_, max_detail_error_px_ > 0.0);
    light_map_.update(*scene.placed().snapshot()->statics);
}

void SceneDrawer::clear(const ColorTarget& target, const glm::vec3& background) {
    const float color[4] = {code_of(background.r), code_of(background.g), code_of(background.b), 1.0f};
    const float farthest = 0.0f;
    gl_.ClearNamedFramebufferfv(target.framebuffer.name(), GL_COLOR, 0, color);
    gl_.ClearNamedFramebufferfv(target.framebuffer.name(), GL_DEPTH, 0, &farthest);
}

void SceneDrawer::clear(const TruthTarget& target) {
    const GLuint nothing[4] = {0, 0, 0, 0};
    const float no_normal[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    const float farthest = 0.0f;
    gl_.ClearNamedFramebufferuiv(target.framebuffer.name(), GL_COLOR, 0, nothing);
    gl_.ClearNamedFramebufferfv(target.framebuffer.name(), GL_COLOR, 1, no_normal);
    gl_.ClearNamedFramebufferfv(target.framebuffer.name(), GL_DEPTH, 0, &farthest);
}

void SceneDrawer::restore(const View& view, const ViewPlan& plan, GpuScene& scene, const ColorTarget* color,
                          ViewTargets& targets, SceneChanges& changes) {
    changes.layer = nullptr;
    changes.shadowed.clear();
    changes.is_mostly_shadowed = changes.is_in_parts = changes.is_put_back = false;
    // Chosen objects are another picture than the one that is kept.
    if (view.only_objects.empty())
        changes.layer = layers_.layer_of(
            view.camera, {view.spec_revision, view.pose, view.quality, scene.placed().statics_number()});
    if (changes.layer == nullptr || !plan.wants_color) return;
    if (view.quality == world::Quality::beautiful) {
        changes.shadowed = shadow_rects(view, plan, scene);
        std::int64_t area = 0, whole = 0;
        for (const auto& tile : changes.shadowed) {
            for (const PixelRect& rect : tile) area += rect.area();
        }
        for (const SourceTile& tile : plan.tiles) whole += tile.size.pixels();
        changes.is_mostly_shadowed = 2 * area > whole;
    }
    if (!changes.layer->color || changes.is_mostly_shadowed) return;
    changes.is_in_parts = find_changes(view, plan, scene, changes);
    if (changes.is_in_parts && color != nullptr) put_back(plan, *color, &targets, changes);
}

void SceneDrawer::put_back(const ViewPlan& plan, const ColorTarget& color, ViewTargets* targets,
                           SceneChanges& changes) {
    const PixelRect whole{0, 0, color.size.width, color.size.height};
    samples_.assign(changes.rects.begin(), changes.rects.end());
    for (PixelRect& rect : samples_) rect = scaled(rect, plan.supersampling);
    // The finished picture of a view stays from instant to instant: only what movers changed in it is put back.
    const bool shows_layer = targets != nullptr && targets->shown_layer == changes.layer->number;
    const std::span<const PixelRect> changed = shows_layer ? targets->changed : std::span(&whole, 1);
    layers_.restore_around(*changes.layer, color, changed, samples_, plan.takes_depth_from_color);
    if (targets != nullptr) {
        targets->shown_layer = changes.layer->number;
        targets->changed.swap(samples_);
    }
    changes.is_put_back = true;
    changes.shown_layer = changes.layer->number;
}

void SceneDrawer::draw(const View& view, const ViewPlan& plan, GpuScene& scene, ViewSources sources,
                       ViewTargets& targets, SceneChanges& changes) {
    if (!state_is_ours_) pass_.begin_instant();
    state_is_ours_ = true;
    ++views_;
    StaticLayers::Layer* const layer = changes.layer;
    const bool is_mostly_shadowed = changes.is_mostly_shadowed;
    if (sources.color != nullptr && changes.is_in_parts) {
        if (!changes.is_put_back) put_back(plan, *sources.color, nullptr, changes);
        draw_changes(view, plan, scene, *sources.color, changes);
        ++views_in_parts_;
        sources.color = nullptr;
        if (sources.truth == nullptr) return;
    }
    ViewSources statics = sources;
    if (sources.color != nullptr) {
        targets.shown_layer = 0;
        if (layer != nullptr && layer->color && !is_mostly_shadowed) {
            layers_.restore(*layer->color, *sources.color);
            draw_shadowed(view, plan, scene, *sources.color, changes.shadowed);
            statics.color = nullptr;
        } else {
            clear(*sources.color, background_of(view, scene.placed()));
        }
    }
    if (sources.truth != nullptr) {
        if (layer != nullptr && layer->truth) {
            layers_.restore(*layer->truth, *sources.truth);
            statics.truth = nullptr;
        } else {
            clear(*sources.truth);
        }
    }
    const bool keeps_color = layer != nullptr && statics.color != nullptr && !layer->color;
    const bool keeps_truth = layer != nullptr && statics.truth != nullptr;
    if (!keeps_color && !keeps_truth) return draw_tiles(view, plan, scene, statics, sources);
    draw_tiles(view, plan, scene, statics, {}, keeps_color ? Shadows::still : Shadows::now);
    if (keeps_color) {
        layers_.keep(*layer, *statics.color);
        if (may_draw_parts(plan) && layer->color) keep_finished(view, plan, scene, *statics.color, *layer);
        draw_shadowed(view, plan, scene, *statics.color, changes.shadowed);
    }
    if (keeps_truth) layers_.keep(*layer, *statics.truth);
    draw_tiles(view, plan, scene, {}, sources);
}

ViewTransform SceneDrawer::transform_of(const View& view, const ViewPlan& plan, const SourceTile& tile) const {
    return make_tile_transform(view.pose, tile.tile_from_optical, tile.size, tile.intrinsics, plan.spec->near_m,
                               plan.spec->far_m);
}

std::vector<std::vector<PixelRect>> SceneDrawer::shadow_rects(const View& view, const ViewPlan& plan,
                                                              const GpuScene& scene) {
    constexpr std::size_t max_rects_per_tile = 8;
    std::vector<std::vector<PixelRect>> rects;
    for (const SourceTile& tile : plan.tiles) {
        const ViewTransform transform = transform_of(view, plan, tile);
        std::vector<PixelRect> changed = shadows_.changed_pixels(transform);
        bodies_.see(make_scene_view(scene.placed(), transform, plan.spec->far_m, view.quality, 0.0), {},
                    scene.placed().movers().bodies());
        changed.insert(changed.end(), bodies_.moving_rects.begin(), bodies_.moving_rects.end());
        rects.push_back(disjoint_cover(std::move(changed), max_rects_per_tile));
    }
    return rects;
}

void SceneDrawer::begin_tile(const View& view, const ViewPlan& plan, const SourceTile& tile, GpuScene& scene,
                             Shadows shadows) {
    const bool is_shadowed = view.quality == world::Quality::beautiful && !shadows_.views().empty();
    PassView pass{make_scene_view(scene.placed(), transform_of(view, plan, tile), plan.spec->far_m, view.quality,
                                  max_detail_error_px_),
                  {},
                  0};
    pass.exposure_gain = scene::exposure_gain_of(*plan.spec);
    if (is_shadowed) {
        pass.shadows = shadows_.views();
        pass.shadow_maps = shadows == Shadows::still ? shadows_.still() : shadows_.now();
    }
    if (pass.has_contact_occlusion) {
        bodies_.see(pass, scene.placed().statics().bodies(),
                    shadows == Shadows::still ? scene::PlacedBodies{} : scene.placed().movers().bodies());
        pass.bodies = &bodies_;
    }
    if (view.quality == world::Quality::beautiful && light_map_.is_there()) pass.light_map = &light_map_;
    pass_.begin_view(pass, scene);
    static_opaque_.clear();
    moving_opaque_.clear();
    blended_.clear();
}

void SceneDrawer::draw_into(GLuint framebuffer, const SourceTile& tile, int factor) {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    const ImageSize size = scaled(tile.size, factor);
    gl_.Viewport(tile.x * factor, tile.y * factor, size.width, size.height);
    gl_.Scissor(tile.x * factor, tile.y * factor, size.width, size.height);
}

bool SceneDrawer::find_changes(const View& view, const ViewPlan& plan, GpuScene& scene, SceneChanges& changes) {
    // Each rectangle is a round of draws; past a few of them, or past half of the picture, a plain copy is cheaper.
    constexpr std::size_t max_rects = 8;
    if (!may_draw_parts(plan)) return false;
    const SourceTile& tile = plan.tiles.front();
    begin_tile(view, plan, tile, scene, Shadows::now);
    changes.shadowed_statics.clear();
    changes.static_blended.clear();
    changes.rects.clear();
    if (!changes.shadowed.empty()) changes.rects = changes.shadowed.front();
    const scene::SceneView& seen = pass_.view();
    seen.see_all(true, changes.rects.empty() ? nullptr : &changes.shadowed_statics, &changes.static_blended);
    changes.movers.see(seen);
    changes.rects.insert(changes.rects.end(), changes.movers.rects.begin(), changes.movers.rects.end());
    changes.rects = disjoint_cover(std::move(changes.rects), max_rects);
    std::int64_t area = 0;
    for (const PixelRect& rect : changes.rects) area += rect.area();
    return 2 * area <= tile.size.pixels();
}

void SceneDrawer::draw_changes(const View& view, const ViewPlan& plan, GpuScene& scene, const ColorTarget& color,
                               const SceneChanges& changes) {
    if (changes.rects.empty()) return;
    const SourceTile& tile = plan.tiles.front();
    begin_tile(view, plan, tile, scene, Shadows::now);
    draw_into(color.framebuffer.name(), tile, plan.supersampling);
    if (!changes.shadowed_statics.empty()) {
        gl_.Enable(GL_SCISSOR_TEST);
        for (const PixelRect& rect : changes.rects) {
            use_scissor(tile, rect, plan.supersampling);
            clear(color, pass_.view().background());
            draw_touching(changes.shadowed_statics, rect);
        }
        gl_.Disable(GL_SCISSOR_TEST);
    }
    // What moves touches nothing outside of its bounds, and those lie in the rectangles: once is enough for all.
    pass_.draw_opaque(changes.movers.opaque);
    // All that is blended comes last, rectangle after rectangle: each change between the two is a flush (DrawPass).
    pass_.begin_blending();
    gl_.Enable(GL_SCISSOR_TEST);
    for (const PixelRect& rect : changes.rects) {
        touching_.clear();
        for (const auto* list : {&changes.static_blended, &changes.movers.blended}) {
            for (const scene::SeenSurface& seen : *list)
                if (pass_.view().touches(seen, {&rect, 1})) touching_.push_back(seen);
        }
        if (touching_.empty()) continue;
        use_scissor(tile, rect, plan.supersampling);
        pass_.draw_sorted(touching_);
    }
    gl_.Disable(GL_SCISSOR_TEST);
    pass_.end_blending();
}

void SceneDrawer::use_scissor(const SourceTile& tile, const PixelRect& rect, int factor) {
    gl_.Scissor((tile.x + rect.x0) * factor, (tile.y + rect.y0) * factor, rect.width() * factor,
                rect.height() * factor);
}

void SceneDrawer::draw_touching(std::span<const scene::SeenSurface> draws, const PixelRect& rect) {
    touching_.clear();
    for (const scene::SeenSurface& seen : draws)
        if (pass_.view().touches(seen, {&rect, 1})) touching_.push_back(seen);
    pass_.draw_opaque(touching_);
}

void SceneDrawer::draw_shadowed(const View& view, const ViewPlan& plan, GpuScene& scene, const ColorTarget& color,
                                std::span<const std::vector<PixelRect>> rects) {
    for (std::size_t i = 0; i < rects.size(); ++i) {
        if (rects[i].empty()) continue;
        const SourceTile& tile = plan.tiles[i];
        begin_tile(view, plan, tile, scene, Shadows::now);
        pass_.view().see_all(true, &static_opaque_, nullptr);
        draw_into(color.framebuffer.name(), tile, plan.supersampling);
        gl_.Enable(GL_SCISSOR_TEST);
        for (const PixelRect& rect : rects[i]) {
            use_scissor(tile, rect, plan.supersampling);
            clear(color, pass_.view().background());
            draw_touching(static_opaque_, rect);
        }
        gl_.Disable(GL_SCISSOR_TEST);
    }
}

void SceneDrawer::keep_finished(const View& view, const ViewPlan& plan, GpuScene& scene, const ColorTarget& color,
                                StaticLayers::Layer& layer) {
    const SourceTile& tile = plan.tiles.front();
    begin_tile(view, plan, tile, scene, Shadows::still);
    pass_.view().see_all(true, nullptr, &blended_);
    if (blended_.empty()) return;
    draw_into(color.framebuffer.name(), tile, plan.supersampling);
    pass_.draw_blended(blended_);
    layers_.keep_finished(layer, color);
}

void SceneDrawer::keep_only(std::span<const ObjectId> objects) {
    if (objects.empty()) return;
    const auto is_other = [&](const scene::SeenSurface& seen) {
        return std::ranges::find(objects, seen.placed->object->id) == objects.end();
    };
    std::erase_if(static_opaque_, is_other);
    std::erase_if(moving_opaque_, is_other);
}

void SceneDrawer::draw_tiles(const View& view, const ViewPlan& plan, GpuScene& scene, const ViewSources& statics,
                             const ViewSources& rest, Shadows shadows) {
    const bool draws_statics = statics.color != nullptr || statics.truth != nullptr;
    const bool draws_rest = rest.color != nullptr || rest.truth != nullptr;
    // Points and lines are wider than the viewport's edge knows.
    const bool is_part = plan.tiles.size() > 1;
    if (is_part) gl_.Enable(GL_SCISSOR_TEST);
    for (const SourceTile& tile : plan.tiles) {
        begin_tile(view, plan, tile, scene, shadows);
        auto* const blended = rest.color != nullptr ? &blended_ : nullptr;
        pass_.view().see_all(true, draws_statics ? &static_opaque_ : nullptr, blended);
        if (draws_rest) pass_.view().see_all(false, &moving_opaque_, blended);
        keep_only(view.only_objects);

        if (const ColorTarget* color = statics.color != nullptr ? statics.color : rest.color) {
            draw_into(color->framebuffer.name(), tile, plan.supersampling);
            if (statics.color != nullptr) pass_.draw_opaque(static_opaque_);
            if (rest.color != nullptr) {
                pass_.draw_opaque(moving_opaque_);
                pass_.draw_blended(blended_);
            }
        }
        if (const TruthTarget* truth = statics.truth != nullptr ? statics.truth : rest.truth) {
            draw_into(truth->framebuffer.name(), tile, 1);
            if (statics.truth != nullptr) pass_.draw_truth(static_opaque_);
            if (rest.truth != nullptr) pass_.draw_truth(moving_opaque_);
        }
    }
    if (is_part) gl_.Disable(GL_SCISSOR_TEST);
}

RenderCounters SceneDrawer::counters() const {
    RenderCounters counters = layers_.counters();
    counters.views = views_;
    counters.views_in_parts = views_in_parts_;
    counters.draws = pass_.draws();
    counters.draw_calls = pass_.draw_calls();
    counters.draws_coarse = pass_.coarse_draws();
    return counters;
}

}  // namespace camrig::render::gl
