#include "core/render/gl/view_painter.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/render/view_frames.h"

namespace camrig {
namespace {

float srgb_of(float linear) {
    const float c = std::fmin(std::fmax(linear, 0.0f), 1.0f);
    return c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1.0f / 2.4f) - 0.055f;
}

bool is_bicubic(LensFilter filter, Quality quality) {
    return filter == LensFilter::bicubic || (filter == LensFilter::automatic && quality == Quality::beautiful);
}

ImageSize scaled(ImageSize size, int factor) {
    return {size.width * factor, size.height * factor};
}

}  // namespace

void ViewPainter::begin_instant() {
    scratch_.next_instant();
    layers_.next_instant();
    state_is_ours_ = false;
}

void ViewPainter::prepare(std::span<const View> views, PaintScene& scene) {
    const auto is_shadowed = [](const View& view) {
        return view.quality == Quality::beautiful && wants(view, FrameKind::color);
    };
    if (std::ranges::none_of(views, is_shadowed)) return;
    state_is_ours_ = false;
    shadows_.update(scene, pass_, max_detail_error_px_ > 0.0);
}

Result<ViewPainter::Plan> ViewPainter::plan_of(const View& view, SourceTile& whole) {
    const CameraSpec& spec = *view.spec;
    if (std::max(spec.size.width, spec.size.height) > max_side_) {
        return error(ErrorKind::unsupported, spec.size.to_string() + " is larger than the device draws; at most " +
                                                 std::to_string(max_side_) + " pixels a side");
    }
    const Antialias antialias = antialias_of(spec, view.quality);
    Plan plan{.spec = spec,
              .source = spec.size,
              .supersampling = supersampling_of(antialias),
              .multisampling = multisampling_of(antialias),
              .is_bicubic = is_bicubic(spec.lens_sampling.filter, view.quality),
              .wants_color = wants(view, FrameKind::color)};
    const bool samples_once = plan.supersampling * plan.multisampling == 1;
    plan.takes_depth_from_color = plan.wants_color && samples_once && wants(view, FrameKind::depth);
    plan.wants_truth = wants(view, FrameKind::instance) || wants(view, FrameKind::semantic) ||
                       wants(view, FrameKind::normal) ||
                       (wants(view, FrameKind::depth) && !plan.takes_depth_from_color);

    auto lens = lenses_.lens_of(view.camera, spec, antialias);
    if (!lens) return std::unexpected(lens.error());
    plan.lens = std::move(*lens);
    if (plan.lens != nullptr) {
        plan.tiles = plan.lens->plan.tiles;
        plan.source = plan.lens->plan.source;
        return plan;
    }
    whole = {.intrinsics = spec.intrinsics, .size = spec.size};
    plan.tiles = {&whole, 1};
    const ImageSize drawn = scaled(spec.size, plan.supersampling);
    if (std::max(drawn.width, drawn.height) > max_side_ || drawn.pixels() * plan.multisampling > max_target_samples) {
        return error(ErrorKind::resource_exhausted,
                     "antialias: " + std::string(to_string(antialias)) + " of " + spec.size.to_string() +
                         " is more than the device draws: at most " + std::to_string(max_side_) +
                         " samples a side and " + std::to_string(max_target_samples >> 20) + " million in all");
    }
    return plan;
}

Result<const ColorTarget*> ViewPainter::color_source(const Plan& plan, ViewTargets& targets) {
    const bool has_depth = !plan.is_resampled();
    std::optional<ColorTarget>& finished = targets.color;
    if (!finished || finished->size != plan.spec.size || static_cast<bool>(finished->depth) != has_depth) {
        finished.reset();
        targets.shown_layer = 0;
        auto made = make_color_target(gl_, plan.spec.size, {.has_depth = has_depth});
        if (!made) return std::unexpected(made.error());
        finished = std::move(*made);
    }
    if (!plan.is_resampled()) return &*finished;
    return scratch_.color(scaled(plan.source, plan.supersampling), {.samples = plan.multisampling});
}

Result<const TruthTarget*> ViewPainter::truth_source(const Plan& plan, ViewTargets& targets) {
    const bool is_warped = plan.lens != nullptr;
    std::optional<TruthTarget>& finished = targets.truth;
    if (!finished || finished->size != plan.spec.size || finished->depth_is_color != is_warped) {
        finished.reset();
        auto made = make_truth_target(gl_, plan.spec.size, is_warped);
        if (!made) return std::unexpected(made.error());
        finished = std::move(*made);
    }
    if (!is_warped) return &*finished;
    return scratch_.truth(plan.source);
}

void ViewPainter::clear(const ColorTarget& target, const Environment& environment) {
    const glm::vec3 background = environment.background * environment.exposure;
    const float color[4] = {srgb_of(background.r), srgb_of(background.g), srgb_of(background.b), 1.0f};
    const float farthest = 0.0f;
    gl_.ClearNamedFramebufferfv(target.framebuffer.name(), GL_COLOR, 0, color);
    gl_.ClearNamedFramebufferfv(target.framebuffer.name(), GL_DEPTH, 0, &farthest);
}

void ViewPainter::clear(const TruthTarget& target) {
    const GLuint nothing[4] = {0, 0, 0, 0};
    const float no_normal[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    const float farthest = 0.0f;
    gl_.ClearNamedFramebufferuiv(target.framebuffer.name(), GL_COLOR, 0, nothing);
    gl_.ClearNamedFramebufferfv(target.framebuffer.name(), GL_COLOR, 1, no_normal);
    gl_.ClearNamedFramebufferfv(target.framebuffer.name(), GL_DEPTH, 0, &farthest);
}

void ViewPainter::draw_scene(const View& view, const Plan& plan, PaintScene& scene, Sources sources,
                             ViewTargets& targets) {
    // Chosen objects are another picture than the one that is kept.
    StaticLayers::Layer* const layer =
        view.only_objects.empty()
            ? layers_.layer_of(view.camera, {view.spec_revision, view.pose, view.quality, scene.statics_number})
            : nullptr;
    // Where the shadows of movers fall, the kept picture is wrong. Past half of the picture a full draw is cheaper.
    std::vector<std::vector<PixelRect>> shadowed;
    bool is_mostly_shadowed = false;
    if (layer != nullptr && sources.color != nullptr && view.quality == Quality::beautiful) {
        shadowed = shadow_rects(view, plan);
        std::int64_t area = 0, whole = 0;
        for (const auto& tile : shadowed) {
            for (const PixelRect& rect : tile) area += rect.area();
        }
        for (const SourceTile& tile : plan.tiles) whole += tile.size.pixels();
        is_mostly_shadowed = 2 * area > whole;
    }
    // Mesa 22.3 llvmpipe copies parts of multisampled pictures wrongly (StaticLayer tests fail); whole ones it can.
    const bool draws_parts = plan.tiles.size() == 1 && plan.multisampling == 1;
    if (sources.color != nullptr && layer != nullptr && layer->color && draws_parts && !is_mostly_shadowed &&
        draw_changes(view, plan, scene, *sources.color, *layer, shadowed, targets)) {
        ++views_in_parts_;
        sources.color = nullptr;
        if (sources.truth == nullptr) return;
    }
    Sources statics = sources;
    if (sources.color != nullptr) {
        targets.shown_layer = 0;
        if (layer != nullptr && layer->color && !is_mostly_shadowed) {
            layers_.restore(*layer->color, *sources.color);
            draw_shadowed(view, plan, scene, *sources.color, shadowed);
            statics.color = nullptr;
        } else {
            clear(*sources.color, scene.environment);
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
        if (draws_parts && layer->color) keep_finished(view, plan, scene, *statics.color, *layer);
        draw_shadowed(view, plan, scene, *statics.color, shadowed);
    }
    if (keeps_truth) layers_.keep(*layer, *statics.truth);
    draw_tiles(view, plan, scene, {}, sources);
}

ViewTransform ViewPainter::transform_of(const View& view, const Plan& plan, const SourceTile& tile) const {
    return make_tile_transform(view.pose, tile.tile_from_optical, tile.size, tile.intrinsics, plan.spec.near_m,
                               plan.spec.far_m);
}

std::vector<std::vector<PixelRect>> ViewPainter::shadow_rects(const View& view, const Plan& plan) const {
    constexpr std::size_t max_rects_per_tile = 8;
    std::vector<std::vector<PixelRect>> rects;
    for (const SourceTile& tile : plan.tiles) {
        rects.push_back(disjoint_cover(shadows_.changed_pixels(transform_of(view, plan, tile)), max_rects_per_tile));
    }
    return rects;
}

void ViewPainter::begin_tile(const View& view, const Plan& plan, const SourceTile& tile, PaintScene& scene,
                             Shadows shadows) {
    const bool is_shadowed = view.quality == Quality::beautiful && !shadows_.views().empty();
    PassView pass{.transform = transform_of(view, plan, tile),
                  .frustum = {},
                  .quality = view.quality,
                  .max_detail_error_px = max_detail_error_px_,
                  .environment = &scene.environment,
                  .lights = scene.lights,
                  .light_sets = &scene.light_sets,
                  .shadows = {},
                  .shadow_maps = 0};
    if (is_shadowed) {
        pass.shadows = shadows_.views();
        pass.shadow_maps = shadows == Shadows::still ? shadows_.still() : shadows_.now();
    }
    pass.frustum = make_frustum(pass.transform, plan.spec.far_m);
    pass_.begin_view(pass, scene.stream);
    static_opaque_.clear();
    moving_opaque_.clear();
    blended_.clear();
}

void ViewPainter::draw_into(GLuint framebuffer, const SourceTile& tile, int factor) {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    const ImageSize size = scaled(tile.size, factor);
    gl_.Viewport(tile.x * factor, tile.y * factor, size.width, size.height);
    gl_.Scissor(tile.x * factor, tile.y * factor, size.width, size.height);
}

std::optional<PixelRect> ViewPainter::bounds_of(const SceneItem& item) const {
    const ViewTransform& transform = pass_.transform();
    return screen_bounds(transform, transform.optical_from(item.world_from_local), item.bounds.min, item.bounds.max);
}

bool ViewPainter::draw_changes(const View& view, const Plan& plan, PaintScene& scene, const ColorTarget& color,
                               const StaticLayers::Layer& layer, std::span<const std::vector<PixelRect>> shadowed,
                               ViewTargets& targets) {
    // Each rectangle is a round of draws; past a few of them, or past half of the picture, a plain copy is cheaper.
    constexpr std::size_t max_rects = 8;
    const SourceTile& tile = plan.tiles.front();
    begin_tile(view, plan, tile, scene, Shadows::now);
    static_blended_.clear();
    std::vector<PixelRect> rects;
    if (!shadowed.empty()) rects = shadowed.front();
    const bool draws_statics = !rects.empty();
    pass_.cull(scene.movers, &moving_opaque_, &blended_);
    pass_.cull(scene.statics, draws_statics ? &static_opaque_ : nullptr, &static_blended_);

    for (const auto* list : {&moving_opaque_, &blended_}) {
        for (const VisibleDraw& draw : *list)
            if (const auto rect = bounds_of(*draw.item)) rects.push_back(*rect);
    }
    rects = disjoint_cover(std::move(rects), max_rects);
    std::int64_t area = 0;
    for (const PixelRect& rect : rects) area += rect.area();
    if (2 * area > tile.size.pixels()) return false;

    const int factor = plan.supersampling;
    std::vector<PixelRect> samples = rects;
    for (PixelRect& rect : samples) rect = {rect.x0 * factor, rect.y0 * factor, rect.x1 * factor, rect.y1 * factor};
    // All copies before all draws: a copy waits for what is being drawn into the same picture.
    // The finished picture of a view stays from instant to instant: only what movers changed in it is put back.
    const bool is_finished = &color == &*targets.color;
    const bool shows_layer = is_finished && targets.shown_layer == layer.number;
    const std::vector<PixelRect> whole{{0, 0, color.size.width, color.size.height}};
    layers_.restore_around(layer, color, shows_layer ? targets.changed : whole, samples, plan.takes_depth_from_color);
    if (is_finished) {
        targets.shown_layer = layer.number;
        targets.changed = samples;
    }
    if (rects.empty()) return true;

    draw_into(color.framebuffer.name(), tile, factor);
    gl_.Enable(GL_SCISSOR_TEST);
    std::vector<VisibleDraw> opaque, blended;
    for (std::size_t i = 0; i < rects.size(); ++i) {
        const auto touches = [&](const VisibleDraw& draw) {
            const auto bounds = bounds_of(*draw.item);
            return bounds && bounds->intersects(rects[i]);
        };
        opaque.clear();
        blended.clear();
        std::ranges::copy_if(moving_opaque_, std::back_inserter(opaque), touches);
        std::ranges::copy_if(static_blended_, std::back_inserter(blended), touches);
        std::ranges::copy_if(blended_, std::back_inserter(blended), touches);
        gl_.Scissor(samples[i].x0, samples[i].y0, samples[i].width(), samples[i].height());
        if (draws_statics) {
            clear(color, scene.environment);
            draw_touching(static_opaque_, rects[i]);
        }
        pass_.draw_opaque(opaque);
        pass_.draw_blended(blended);
    }
    gl_.Disable(GL_SCISSOR_TEST);
    return true;
}

void ViewPainter::draw_touching(std::span<const VisibleDraw> draws, const PixelRect& rect) {
    std::vector<VisibleDraw> touching;
    for (const VisibleDraw& draw : draws) {
        const auto bounds = bounds_of(*draw.item);
        if (bounds && bounds->intersects(rect)) touching.push_back(draw);
    }
    pass_.draw_opaque(touching);
}

void ViewPainter::draw_shadowed(const View& view, const Plan& plan, PaintScene& scene, const ColorTarget& color,
                                std::span<const std::vector<PixelRect>> rects) {
    for (std::size_t i = 0; i < rects.size(); ++i) {
        if (rects[i].empty()) continue;
        const SourceTile& tile = plan.tiles[i];
        begin_tile(view, plan, tile, scene, Shadows::now);
        pass_.cull(scene.statics, &static_opaque_, nullptr);
        draw_into(color.framebuffer.name(), tile, plan.supersampling);
        gl_.Enable(GL_SCISSOR_TEST);
        for (const PixelRect& rect : rects[i]) {
            const int factor = plan.supersampling;
            gl_.Scissor((tile.x + rect.x0) * factor, (tile.y + rect.y0) * factor, rect.width() * factor,
                        rect.height() * factor);
            clear(color, scene.environment);
            draw_touching(static_opaque_, rect);
        }
        gl_.Disable(GL_SCISSOR_TEST);
    }
}

void ViewPainter::keep_finished(const View& view, const Plan& plan, PaintScene& scene, const ColorTarget& color,
                                StaticLayers::Layer& layer) {
    const SourceTile& tile = plan.tiles.front();
    begin_tile(view, plan, tile, scene, Shadows::still);
    pass_.cull(scene.statics, nullptr, &blended_);
    if (blended_.empty()) return;
    draw_into(color.framebuffer.name(), tile, plan.supersampling);
    pass_.draw_blended(blended_);
    layers_.keep_finished(layer, color);
}

void ViewPainter::keep_only(std::span<const ObjectId> objects) {
    if (objects.empty()) return;
    const auto is_other = [&](const VisibleDraw& draw) {
        return std::ranges::find(objects, draw.item->object) == objects.end();
    };
    std::erase_if(static_opaque_, is_other);
    std::erase_if(moving_opaque_, is_other);
}

void ViewPainter::draw_tiles(const View& view, const Plan& plan, PaintScene& scene, const Sources& statics,
                             const Sources& rest, Shadows shadows) {
    const bool draws_statics = statics.color != nullptr || statics.truth != nullptr;
    const bool draws_rest = rest.color != nullptr || rest.truth != nullptr;
    // Points and lines are wider than the viewport's edge knows.
    const bool is_part = plan.tiles.size() > 1;
    if (is_part) gl_.Enable(GL_SCISSOR_TEST);
    for (const SourceTile& tile : plan.tiles) {
        begin_tile(view, plan, tile, scene, shadows);
        auto* const blended = rest.color != nullptr ? &blended_ : nullptr;
        pass_.cull(scene.statics, draws_statics ? &static_opaque_ : nullptr, blended);
        if (draws_rest) pass_.cull(scene.movers, &moving_opaque_, blended);
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

RenderCounters ViewPainter::counters() const {
    RenderCounters counters = layers_.counters();
    counters.views = views_;
    counters.views_in_parts = views_in_parts_;
    counters.draws = pass_.draws();
    counters.draws_coarse = pass_.coarse_draws();
    return counters;
}

Result<void> ViewPainter::finish_color(const Plan& plan, const ColorTarget& source, const ViewTargets& targets) {
    const ColorTarget* samples = &source;
    if (plan.lens == nullptr) {
        images_.resolve(source, plan.supersampling, *targets.color);
        return {};
    }
    if (plan.multisampling > 1) {
        auto resolved = scratch_.color(source.size, {.has_depth = false});
        if (!resolved) return std::unexpected(resolved.error());
        images_.resolve(source, 1, **resolved);
        samples = *resolved;
    }
    images_.warp_color(*plan.lens, *samples, plan.supersampling, plan.is_bicubic, *targets.color);
    return {};
}

Result<PaintedView> ViewPainter::paint(const View& view, PaintScene& scene, ViewTargets& targets) {
    SourceTile whole;
    auto planned = plan_of(view, whole);
    if (!planned) return std::unexpected(planned.error());
    const Plan& plan = *planned;

    Sources sources;
    if (plan.wants_color) {
        auto made = color_source(plan, targets);
        if (!made) return std::unexpected(made.error());
        sources.color = *made;
    }
    if (plan.wants_truth || (plan.takes_depth_from_color && plan.lens != nullptr)) {
        auto made = truth_source(plan, targets);
        if (!made) return std::unexpected(made.error());
        if (plan.wants_truth) sources.truth = *made;
    }
    const auto [color, truth] = sources;

    if (!state_is_ours_) pass_.begin_instant();
    state_is_ours_ = true;
    draw_scene(view, plan, scene, sources, targets);
    ++views_;

    if (plan.is_resampled()) state_is_ours_ = false;
    if (plan.is_resampled() && color != nullptr) {
        if (auto finished = finish_color(plan, *color, targets); !finished) return std::unexpected(finished.error());
    }
    if (plan.lens != nullptr && truth != nullptr) images_.warp_truth(*plan.lens, *truth, *targets.truth);
    if (plan.lens != nullptr && plan.takes_depth_from_color && truth == nullptr) {
        images_.warp_depth(*plan.lens, *color, *targets.truth);
    }

    PaintedView painted;
    if (color != nullptr) painted.color = {.framebuffer = targets.color->framebuffer.name()};
    if (targets.truth) {
        painted.truth = {.framebuffer = targets.truth->framebuffer.name(),
                         .depth_is_color = targets.truth->depth_is_color};
    }
    painted.depth = plan.takes_depth_from_color && plan.lens == nullptr ? painted.color : painted.truth;
    painted.transform =
        make_view_transform(view.pose, plan.spec.size, plan.spec.intrinsics, plan.spec.near_m, plan.spec.far_m);
    painted.lens = plan.lens;
    return painted;
}

}  // namespace camrig
