#include "core/render/gl/view_painter.h"

#include <algorithm>

#include "core/render/view_frames.h"

namespace camrig::render::gl {
namespace {

bool is_bicubic(world::LensFilter filter, world::Quality quality) {
    return filter == world::LensFilter::bicubic ||
           (filter == world::LensFilter::automatic && quality == world::Quality::beautiful);
}

}  // namespace

Result<ViewPlan> ViewPainter::plan_of(const View& view, SourceTile& whole) {
    const world::CameraSpec& spec = *view.spec;
    if (std::max(spec.size.width, spec.size.height) > max_side_) {
        return error(ErrorKind::unsupported, spec.size.to_string() + " is larger than the device draws; at most " +
                                                 std::to_string(max_side_) + " pixels a side");
    }
    const world::Antialias antialias = antialias_of(spec, view.quality);
    ViewPlan plan{.spec = &spec,
                  .source = spec.size,
                  .supersampling = supersampling_of(antialias),
                  .multisampling = multisampling_of(antialias),
                  .is_bicubic = is_bicubic(spec.lens_sampling.filter, view.quality),
                  .wants_color = wants(view, frame::FrameKind::color)};
    const bool samples_once = plan.supersampling * plan.multisampling == 1;
    plan.takes_depth_from_color = plan.wants_color && samples_once && wants(view, frame::FrameKind::depth);
    plan.wants_truth = wants(view, frame::FrameKind::instance) || wants(view, frame::FrameKind::semantic) ||
                       wants(view, frame::FrameKind::normal) ||
                       (wants(view, frame::FrameKind::depth) && !plan.takes_depth_from_color);

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

Result<const ColorTarget*> ViewPainter::color_source(const ViewPlan& plan, ViewTargets& targets) {
    const bool has_depth = !plan.is_resampled();
    std::optional<ColorTarget>& finished = targets.color;
    if (!finished || finished->size != plan.spec->size || static_cast<bool>(finished->depth) != has_depth) {
        finished.reset();
        targets.shown_layer = 0;
        auto made = make_color_target(gl_, plan.spec->size, {.has_depth = has_depth, .has_codes = has_codes_});
        if (!made) return std::unexpected(made.error());
        finished = std::move(*made);
    }
    if (!plan.is_resampled()) return &*finished;
    return scratch_.color(scaled(plan.source, plan.supersampling), {.samples = plan.multisampling});
}

Result<const TruthTarget*> ViewPainter::truth_source(const ViewPlan& plan, ViewTargets& targets) {
    const bool is_warped = plan.lens != nullptr;
    std::optional<TruthTarget>& finished = targets.truth;
    if (!finished || finished->size != plan.spec->size || finished->depth_is_color != is_warped) {
        finished.reset();
        auto made = make_truth_target(gl_, plan.spec->size, is_warped);
        if (!made) return std::unexpected(made.error());
        finished = std::move(*made);
    }
    if (!is_warped) return &*finished;
    return scratch_.truth(plan.source);
}

Result<void> ViewPainter::finish_color(const ViewPlan& plan, const ColorTarget& source, const ViewTargets& targets) {
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

void ViewPainter::begin_instant() {
    scratch_.next_instant();
    drawer_.begin_instant();
}

void ViewPainter::prepare(std::span<const View> views, GpuScene& scene, std::map<CameraId, ViewTargets>& targets) {
    drawer_.prepare(views, scene);
    if (prepared_.size() < views.size()) prepared_.resize(views.size());
    for (std::size_t i = 0; i < views.size(); ++i) {
        ViewTargets& of_view = targets[views[i].camera];
        prepared_[i].is_planned = prepare(views[i], scene, of_view, prepared_[i]);
    }
}

Result<void> ViewPainter::prepare(const View& view, GpuScene& scene, ViewTargets& targets, Prepared& prepared) {
    auto planned = plan_of(view, prepared.whole);
    if (!planned) return std::unexpected(planned.error());
    prepared.plan = std::move(*planned);
    const ColorTarget* own = nullptr;
    if (prepared.plan.wants_color && !prepared.plan.is_resampled()) {
        auto made = color_source(prepared.plan, targets);
        if (!made) return std::unexpected(made.error());
        own = *made;
    }
    drawer_.restore(view, prepared.plan, scene, own, targets, prepared.changes);
    return {};
}

Result<PaintedView> ViewPainter::paint(const View& view, std::size_t index, GpuScene& scene, ViewTargets& targets) {
    Prepared& prepared = prepared_[index];
    if (!prepared.is_planned) return std::unexpected(prepared.is_planned.error());
    const ViewPlan plan = std::move(prepared.plan);

    ViewSources sources;
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
    drawer_.draw(view, plan, scene, sources, targets, prepared.changes);

    if (plan.is_resampled()) drawer_.lose_state();
    if (plan.is_resampled() && color != nullptr) {
        if (auto finished = finish_color(plan, *color, targets); !finished) return std::unexpected(finished.error());
    }
    if (plan.lens != nullptr && truth != nullptr) images_.warp_truth(*plan.lens, *truth, *targets.truth);
    if (plan.lens != nullptr && plan.takes_depth_from_color && truth == nullptr) {
        images_.warp_depth(*plan.lens, *color, *targets.truth);
    }

    PaintedView painted;
    if (color != nullptr) {
        painted.color = {.framebuffer = targets.color->framebuffer.name(), .codes = targets.color->codes.name()};
    }
    if (targets.truth) {
        painted.truth = {.framebuffer = targets.truth->framebuffer.name(),
                         .depth_is_color = targets.truth->depth_is_color};
    }
    painted.depth = plan.takes_depth_from_color && plan.lens == nullptr ? painted.color : painted.truth;
    painted.transform =
        make_view_transform(view.pose, plan.spec->size, plan.spec->intrinsics, plan.spec->near_m, plan.spec->far_m);
    painted.lens = plan.lens;
    // A lens puts rows elsewhere.
    if (color != nullptr && prepared.changes.is_in_parts && plan.lens == nullptr && prepared.changes.shown_layer != 0) {
        painted.damage = frame::Damage::since(static_cast<std::int64_t>(prepared.changes.shown_layer));
        for (const PixelRect& rect : prepared.changes.rects) painted.damage.add(rect.y0, rect.y1);
    }
    return painted;
}

}  // namespace camrig::render::gl
