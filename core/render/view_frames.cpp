#include "core/render/view_frames.h"

#include <unordered_map>

#include "core/frame/clock_text.h"
#include "core/frame/code_strip.h"
#include "core/frame/tone.h"

namespace camrig::render {

namespace {

double samples_of(const View& view) {
    const world::Antialias antialias = antialias_of(*view.spec, view.quality);
    const int side = supersampling_of(antialias);
    return static_cast<double>(view.spec->size.pixels()) * side * side * multisampling_of(antialias);
}

}  // namespace

void share_cost(TimeNs spent_ns, std::span<const View> views, std::span<TimeNs> cost_ns) {
    double all = 0.0;
    for (const View& view : views) all += samples_of(view);
    for (std::size_t i = 0; i < views.size(); ++i)
        cost_ns[i] += static_cast<TimeNs>(static_cast<double>(spent_ns) * samples_of(views[i]) / all);
}

std::shared_ptr<frame::Frame> acquire_frame(frame::FramePool& pool, const View& view, frame::FrameKind kind,
                                            frame::PixelFormat format, TimeNs world_ns, TimeNs monotonic_ns,
                                            const std::optional<sensor::Exposure>& exposure) {
    const auto reading = exposure ? std::optional(exposure->reading) : std::nullopt;
    return pool.acquire({.camera_id = view.camera,
                         .camera = view.name,
                         .sequence = view.sequence,
                         .world_ns = world_ns,
                         .monotonic_ns = monotonic_ns,
                         .size = view.spec->size,
                         .kind = kind,
                         .format = format,
                         .clock = clock_of(view, reading),
                         .sensor = reading,
                         .faults = view.faults});
}

Result<std::optional<sensor::Exposure>> exposure_of(const View& view, const world::Snapshot& snapshot) {
    if (!view.spec->sensor) return std::nullopt;
    sensor::SensorSetup setup{.spec = *view.spec->sensor,
                              .size = view.spec->size,
                              .intrinsics = view.spec->intrinsics,
                              .rate = view.spec->rate};
    if (!setup.spec.lux) setup.spec.lux = snapshot.statics->environment.lux;
    const auto known = view.sensor != nullptr ? view.sensor : std::make_shared<sensor::CameraSensor>();
    auto exposure = known->exposure_of(setup, view.sequence, snapshot.world_ns);
    if (!exposure) return std::unexpected(exposure.error());
    return std::optional(std::move(*exposure));
}

std::optional<ClockReading> clock_of(const View& view, const std::optional<SensorReading>& sensor) {
    const auto& past = view.failing && view.failing->shown_past ? view.failing->shown_past : view.past;
    return sensor && past ? past->clock_at(sensor->exposure_start_ns) : view.clock;
}

frame::PixelFormat raw_format(sensor::ColorFilter filter) {
    switch (filter) {
        case sensor::ColorFilter::mono:
            return frame::PixelFormat::gray16;
        case sensor::ColorFilter::rgb:
            return frame::PixelFormat::rgb16_planes;
        case sensor::ColorFilter::rggb:
            return frame::PixelFormat::bayer_rggb16;
        case sensor::ColorFilter::grbg:
            return frame::PixelFormat::bayer_grbg16;
        case sensor::ColorFilter::gbrg:
            return frame::PixelFormat::bayer_gbrg16;
        case sensor::ColorFilter::bggr:
            return frame::PixelFormat::bayer_bggr16;
    }
    CHECK(false);
    return frame::PixelFormat::gray16;
}

void ids_to_classes(const world::Snapshot& snapshot, frame::Frame& frame) {
    std::unordered_map<std::uint32_t, std::uint32_t> class_of{{0, 0}};
    for (const auto* instances : {&snapshot.statics->objects, &snapshot.movers}) {
        for (const world::Instance& instance : *instances)
            class_of[static_cast<std::uint32_t>(instance.info->id)] = instance.info->class_number;
    }
    auto* const pixels = reinterpret_cast<std::uint32_t*>(frame.mutable_bytes().data());
    // Neighbours mostly show the same object.
    std::uint32_t id = 0, number = 0;
    for (std::int64_t i = 0; i < frame.info().size.pixels(); ++i) {
        if (pixels[i] != id) {
            id = pixels[i];
            const auto found = class_of.find(id);
            CHECK(found != class_of.end());
            number = found->second;
        }
        pixels[i] = number;
    }
}

void finish_color(const View& view, frame::Frame& frame) {
    frame::apply_tone(frame.mutable_bytes(), view.spec->controls);
    if (view.spec->clock_text) {
        const auto [first_row, end_row] = frame::clock_text_rows(frame.info().size);
        frame.add_damage(first_row, end_row);
        frame::draw_clock_text(frame.mutable_bytes(), frame.info().size, frame.info().stamp_ns());
    }
    if (!view.spec->code_strip) return;
    frame.add_damage(0, frame::code_strip_rows * frame::code_strip_cell(frame.info().size));
    frame::draw_code_strip(frame.mutable_bytes(), frame.info().size,
                           {.camera = static_cast<std::uint8_t>(view.camera_number),
                            .sequence = static_cast<std::uint32_t>(view.sequence),
                            .world_ns = frame.info().world_ns});
}

FinishedPixels finished_pixels(const View& view) {
    if (!frame::changes_nothing(view.spec->controls)) return FinishedPixels::all;
    return view.spec->clock_text || view.spec->code_strip ? FinishedPixels::rows : FinishedPixels::none;
}

}  // namespace camrig::render
