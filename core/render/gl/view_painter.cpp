#include "core/render/gl/view_painter.h"

#include <cmath>

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

Result<ViewPainter::Plan> ViewPainter::plan_of(const View& view, SourceTile& whole) {
    const CameraSpec& spec = *view.spec;
    if (std::max(spec.size.width, spec.size.height) > max_side_) {
        return error(ErrorKind::unsupported, spec.size.to_string() + " is larger than the device draws; at most " +
                                                 std::to_string(max_side_) + " pixels a side");
    }
    if (wants(view, FrameKind::semantic)) {
        return error(ErrorKind::unsupported, "semantic pictures are not drawn yet");
    }
    Plan plan{.spec = spec,
              .source = spec.size,
              .supersampling = supersampling_of(spec.antialias),
              .multisampling = multisampling_of(spec.antialias),
              .is_bicubic = is_bicubic(spec.lens_sampling.filter, view.quality),
              .wants_color = wants(view, FrameKind::color)};
    const bool samples_once = plan.supersampling * plan.multisampling == 1;
    plan.takes_depth_from_color = plan.wants_color && samples_once && wants(view, FrameKind::depth);
    plan.wants_truth = wants(view, FrameKind::instance) || wants(view, FrameKind::normal) ||
                       (wants(view, FrameKind::depth) && !plan.takes_depth_from_color);

    auto lens = lenses_.lens_of(view.camera, spec);
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
                     "antialias: " + std::string(to_string(spec.antialias)) + " of " + spec.size.to_string() +
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

void ViewPainter::draw_scene(const View& view, const Plan& plan, PaintScene& scene, const Sources& sources) {
    StaticLayers::Layer* const layer =
        layers_.layer_of(view.camera, {view.spec_revision, view.pose, view.quality, scene.statics_number});
    Sources statics = sources;
    if (sources.color != nullptr) {
        if (layer != nullptr && layer->color) {
            layers_.restore(*layer->color, *sources.color);
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
    const bool is_kept = layer != nullptr && (statics.color != nullptr || statics.truth != nullptr);
    if (!is_kept) return draw_tiles(view, plan, scene, statics, sources);
    draw_tiles(view, plan, scene, statics, {});
    if (statics.color != nullptr) layers_.keep(*layer, *statics.color);
    if (statics.truth != nullptr) layers_.keep(*layer, *statics.truth);
    draw_tiles(view, plan, scene, {}, sources);
}

void ViewPainter::draw_tiles(const View& view, const Plan& plan, PaintScene& scene, const Sources& statics,
                             const Sources& rest) {
    const CameraSpec& spec = plan.spec;
    const bool draws_statics = statics.color != nullptr || statics.truth != nullptr;
    const bool draws_rest = rest.color != nullptr || rest.truth != nullptr;
    // Points and lines are wider than the viewport's edge knows.
    const bool is_part = plan.tiles.size() > 1;
    if (is_part) gl_.Enable(GL_SCISSOR_TEST);
    for (const SourceTile& tile : plan.tiles) {
        PassView pass{.transform = make_tile_transform(view.pose, tile.tile_from_optical, tile.size, tile.intrinsics,
                                                       spec.near_m, spec.far_m),
                      .frustum = {},
                      .quality = view.quality,
                      .max_detail_error_px = max_detail_error_px_,
                      .environment = &scene.environment,
                      .lights = scene.lights,
                      .light_sets = &scene.light_sets};
        pass.frustum = make_frustum(pass.transform, spec.far_m);
        pass_.begin_view(pass, scene.stream);
        static_opaque_.clear();
        moving_opaque_.clear();
        blended_.clear();
        auto* const blended = rest.color != nullptr ? &blended_ : nullptr;
        pass_.cull(scene.statics, draws_statics ? &static_opaque_ : nullptr, blended);
        if (draws_rest) pass_.cull(scene.movers, &moving_opaque_, blended);

        const auto draw_into = [&](GLuint framebuffer, int factor) {
            gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
            const int x = tile.x * factor, y = tile.y * factor;
            const ImageSize size = scaled(tile.size, factor);
            gl_.Viewport(x, y, size.width, size.height);
            if (is_part) gl_.Scissor(x, y, size.width, size.height);
        };
        if (const ColorTarget* color = statics.color != nullptr ? statics.color : rest.color) {
            draw_into(color->framebuffer.name(), plan.supersampling);
            if (statics.color != nullptr) pass_.draw_opaque(static_opaque_);
            if (rest.color != nullptr) {
                pass_.draw_opaque(moving_opaque_);
                pass_.draw_blended(blended_);
            }
        }
        if (const TruthTarget* truth = statics.truth != nullptr ? statics.truth : rest.truth) {
            draw_into(truth->framebuffer.name(), 1);
            if (statics.truth != nullptr) pass_.draw_truth(static_opaque_);
            if (rest.truth != nullptr) pass_.draw_truth(moving_opaque_);
        }
    }
    if (is_part) gl_.Disable(GL_SCISSOR_TEST);
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
    draw_scene(view, plan, scene, sources);

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
