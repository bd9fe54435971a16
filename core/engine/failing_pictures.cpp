#include "core/engine/failing_pictures.h"

#include <algorithm>

#include "core/fault/mask.h"
#include "core/fault/picture.h"
#include "core/render/view_frames.h"

namespace camrig::engine {
namespace {

using frame::Frame, frame::FrameRef, frame::PixelFormat;
constexpr auto color = index_of(frame::FrameKind::color);

bool has_failing_color(const render::View& view) {
    return view.failing && view.kinds[color];
}

bool wants_numbers(const render::View& view) {
    return view.kinds[index_of(frame::FrameKind::sensor)];
}

bool wants_soiling(const render::View& view) {
    return view.kinds[index_of(frame::FrameKind::soiling)];
}

/// The kept frames in all formats that are wanted; none: one is not there.
std::vector<FrameRef> kept_for(const render::View& view) {
    std::vector<FrameRef> kept;
    for (const FrameRef& one : view.failing->kept)
        if (view.color_formats.contains(one->info().format)) kept.push_back(one);
    const bool is_all = std::ranges::all_of(frame::color_formats, [&](PixelFormat format) {
        return !view.color_formats.contains(format) ||
               std::ranges::any_of(kept, [&](const FrameRef& one) { return one->info().format == format; });
    });
    return is_all ? kept : std::vector<FrameRef>{};
}

/// The frame that goes out with this one's picture.
frame::FrameInfo sent_info(const render::View& view, frame::FrameInfo info, TimeNs monotonic_ns) {
    info.damage = {};
    info.monotonic_ns = monotonic_ns;
    info.faults = view.faults;
    if (const auto& as = view.failing->shown_as) {
        // A sensor's numbers are those of the picture; that it was just taken is what its driver says.
        if (info.sensor) {
            info.sensor->exposure_start_ns += as->world_ns - info.world_ns;
            info.sensor->exposure_end_ns += as->world_ns - info.world_ns;
        }
        info.sequence = as->sequence;
        info.world_ns = as->world_ns;
    }
    info.clock = render::clock_of(view, info.sensor);
    return info;
}

/// Of a picture that nobody draws.
frame::FrameInfo own_info(const render::View& view, const world::Snapshot& snapshot, TimeNs monotonic_ns) {
    // A sensor that cannot be made fails where its pictures are drawn.
    const auto exposure = render::exposure_of(view, snapshot);
    const auto sensor = exposure && *exposure ? std::optional((*exposure)->reading) : std::nullopt;
    return {.camera_id = view.camera,
            .camera = view.name,
            .sequence = view.sequence,
            .world_ns = snapshot.world_ns,
            .monotonic_ns = monotonic_ns,
            .size = view.spec->size,
            .clock = render::clock_of(view, sensor),
            .sensor = sensor,
            .faults = view.faults};
}

FrameRef hidden(const render::View& view, const world::Snapshot& snapshot, TimeNs monotonic_ns) {
    const ImageSize size = view.spec->size;
    std::vector<std::byte> pixels(static_cast<std::size_t>(4 * size.pixels()));
    for (std::size_t i = 3; i < pixels.size(); i += 4) pixels[i] = std::byte{255};
    fault::change_picture(*view.failing->faults, size, pixels);
    return std::make_shared<const Frame>(sent_info(view, own_info(view, snapshot, monotonic_ns), monotonic_ns),
                                         std::move(pixels));
}

/// What hides this frame's scene, whatever earlier picture it may have.
FrameRef soiling_of(const render::View& view, const world::Snapshot& snapshot, TimeNs monotonic_ns) {
    const std::vector<std::uint8_t> mask = fault::hidden_mask(view.faults.get(), view.spec->size);
    const auto bytes = std::as_bytes(std::span(mask));
    frame::FrameInfo info = own_info(view, snapshot, monotonic_ns);
    info.kind = frame::FrameKind::soiling;
    info.format = PixelFormat::gray8;
    return std::make_shared<const Frame>(std::move(info), std::vector<std::byte>(bytes.begin(), bytes.end()));
}

/// Puts the lower rows of the picture before it into one that is torn. That is drawn from what there was then, so that
/// it does not depend on who read it.
Result<void> tear(render::Renderer& renderer, const render::FailingPicture& failing, ImageSize size,
                  std::vector<std::byte>& pixels) {
    const render::EarlierPicture& before = *failing.torn_with;
    auto drawn = renderer.draw(before.snapshot, before.monotonic_ns, std::span(&before.view, 1));
    if (!drawn) return std::unexpected(drawn.error());
    for (const FrameRef& frame : drawn->set.frames) {
        if (frame->info().kind != frame::FrameKind::color || frame->info().format != PixelFormat::rgba8) continue;
        std::vector<std::byte> old(frame->bytes().begin(), frame->bytes().end());
        if (before.view.failing && before.view.failing->faults)
            fault::change_picture(*before.view.failing->faults, size, old);
        const auto row_bytes = 4 * static_cast<std::ptrdiff_t>(size.width);
        const auto kept = (size.height - fault::torn_rows(*failing.faults, size.height)) * row_bytes;
        std::copy(old.begin() + kept, old.end(), pixels.begin() + kept);
    }
    return {};
}

Result<FrameRef> changed(render::Renderer& renderer, const render::View& view, const FrameRef& drawn,
                         TimeNs monotonic_ns) {
    const frame::FrameInfo info = sent_info(view, drawn->info(), monotonic_ns);
    if (!view.failing->faults) return FrameRef(std::make_shared<const Frame>(info, drawn));
    CHECK(info.format == PixelFormat::rgba8);
    std::vector<std::byte> pixels(drawn->bytes().begin(), drawn->bytes().end());
    fault::change_picture(*view.failing->faults, info.size, pixels);
    if (view.failing->torn_with)
        if (auto torn = tear(renderer, *view.failing, info.size, pixels); !torn) return std::unexpected(torn.error());
    return FrameRef(std::make_shared<const Frame>(info, std::move(pixels)));
}

}  // namespace

Result<render::Renderer::Finished> draw_failing(render::Renderer& renderer, const world::SnapshotRef& snapshot,
                                                TimeNs monotonic_ns, std::span<const render::View> views) {
    const auto is_changed = [](const render::View& view) {
        return has_failing_color(view) || wants_soiling(view) || (view.failing && wants_numbers(view));
    };
    if (std::ranges::none_of(views, is_changed)) return renderer.draw(snapshot, monotonic_ns, views);

    std::vector<render::View> drawn_views;
    std::vector<std::vector<FrameRef>> ready(views.size());
    const auto is_drawn = [&](std::size_t i) { return ready[i].empty() || wants_numbers(views[i]); };
    for (std::size_t i = 0; i < views.size(); ++i) {
        const render::View& view = views[i];
        if (wants_soiling(view)) ready[i].push_back(soiling_of(view, *snapshot, monotonic_ns));
        if (has_failing_color(view)) {
            for (const FrameRef& kept : kept_for(view))
                ready[i].push_back(std::make_shared<const Frame>(sent_info(view, kept->info(), monotonic_ns), kept));
            if (ready[i].empty() && view.failing->faults && fault::hides_picture(*view.failing->faults))
                ready[i].push_back(hidden(view, *snapshot, monotonic_ns));
        }
        if (is_drawn(i)) drawn_views.push_back(view);
        // The numbers are of this exposure, whatever picture is shown.
        if (is_drawn(i) && !ready[i].empty()) {
            drawn_views.back().kinds[color] = false;
            drawn_views.back().color_formats = {};
        }
    }
    render::Renderer::Finished finished;
    if (!drawn_views.empty()) {
        auto drawn = renderer.draw(snapshot, monotonic_ns, drawn_views);
        if (!drawn) return drawn;
        finished = std::move(*drawn);
    }
    // In the order of all views.
    std::vector<FrameRef> frames;
    std::vector<TimeNs> cost_ns;
    std::size_t next_drawn = 0;
    for (std::size_t i = 0; i < views.size(); ++i) {
        const render::View& view = views[i];
        cost_ns.push_back(!is_drawn(i) || finished.cost_ns.empty() ? not_drawn_ns : finished.cost_ns[next_drawn]);
        next_drawn += is_drawn(i) ? 1 : 0;
        frames.insert(frames.end(), ready[i].begin(), ready[i].end());
        if (!is_drawn(i)) continue;
        for (FrameRef& frame : finished.set.frames) {
            if (frame->info().camera_id != view.camera) continue;
            const bool is_failing = has_failing_color(view) && frame->info().kind == frame::FrameKind::color;
            if (is_failing) {
                auto made = changed(renderer, view, frame, monotonic_ns);
                if (!made) return std::unexpected(made.error());
                frames.push_back(std::move(*made));
            } else if (view.failing && frame->info().kind == frame::FrameKind::sensor) {
                // Shown again, with the times of the frame that shows it.
                frames.push_back(std::make_shared<const Frame>(sent_info(view, frame->info(), monotonic_ns), frame));
            } else {
                frames.push_back(frame);
            }
            frame = nullptr;
        }
        std::erase(finished.set.frames, nullptr);
    }
    finished.set.frames = std::move(frames);
    finished.cost_ns = std::move(cost_ns);
    return finished;
}

TimeNs shown_ns(const render::View& view, const world::Snapshot& snapshot) {
    return view.failing && view.failing->shown_as ? view.failing->shown_as->world_ns : snapshot.world_ns;
}

}  // namespace camrig::engine
