#include "core/render/null_renderer.h"

#include <array>
#include <cstring>
#include <limits>
#include <span>

#include "core/base/clock.h"
#include "core/render/view_frames.h"

namespace camrig::render {
namespace {

void paint_color(const View& view, TimeNs world_ns, std::span<std::byte> out) {
    const ImageSize size = view.spec->size;
    const std::uint8_t blue = null_pattern_blue(view.camera_number, view.sequence, world_ns);
    auto* pixel = reinterpret_cast<std::uint8_t*>(out.data());
    for (int y = 0; y < size.height; ++y) {
        const auto green = static_cast<std::uint8_t>(255 * y / size.height);
        for (int x = 0; x < size.width; ++x, pixel += 4) {
            pixel[0] = static_cast<std::uint8_t>(255 * x / size.width);
            pixel[1] = green;
            pixel[2] = blue;
            pixel[3] = 255;
        }
    }
}

void paint_depth(ImageSize size, std::span<std::byte> out) {
    auto* pixel = reinterpret_cast<float*>(out.data());
    for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
            *pixel++ = y + 1 == size.height ? std::numeric_limits<float>::infinity()
                                            : 1.0f + 0.01f * static_cast<float>(x + y);
        }
    }
}

void paint_ids(ImageSize size, std::span<std::byte> out) {
    auto* pixel = reinterpret_cast<std::uint32_t*>(out.data());
    const int blocks_per_row = (size.width + 7) / 8;
    for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x)
            *pixel++ = static_cast<std::uint32_t>((y / 8) * blocks_per_row + x / 8) % 16;
    }
}

void paint_normals(ImageSize size, std::span<std::byte> out) {
    constexpr std::array<float, 3> towards_camera{0.0f, 0.0f, -1.0f};
    for (std::int64_t i = 0; i < size.pixels(); ++i) std::memcpy(out.data() + 12 * i, towards_camera.data(), 12);
}

void paint(frame::FrameKind kind, const View& view, TimeNs world_ns, frame::Frame& frame) {
    const ImageSize size = view.spec->size;
    switch (kind) {
        case frame::FrameKind::color:
            paint_color(view, world_ns, frame.mutable_bytes());
            finish_color(view, frame);
            return;
        case frame::FrameKind::depth:
            return paint_depth(size, frame.mutable_bytes());
        case frame::FrameKind::instance:
        case frame::FrameKind::semantic:
            return paint_ids(size, frame.mutable_bytes());
        case frame::FrameKind::normal:
            return paint_normals(size, frame.mutable_bytes());
        case frame::FrameKind::sensor:
        case frame::FrameKind::flow:
        case frame::FrameKind::soiling:
            break;
    }
}

}  // namespace

std::uint8_t null_pattern_blue(std::uint32_t camera_number, std::int64_t sequence, TimeNs world_ns) {
    std::uint64_t hash = camera_number;
    for (const auto word : {static_cast<std::uint64_t>(sequence), static_cast<std::uint64_t>(world_ns)}) {
        hash = (hash ^ word) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 29;
    }
    return static_cast<std::uint8_t>(hash >> 24);
}

NullRenderer::NullRenderer(std::shared_ptr<frame::FramePool> pool) : pool_(std::move(pool)) {
    CHECK(pool_ != nullptr);
}

Result<Renderer::Finished> NullRenderer::draw(const world::SnapshotRef& snapshot, TimeNs monotonic_ns,
                                              std::span<const View> views) {
    thread_.check();
    const TimeNs start_ns = monotonic_now_ns();
    Finished finished;
    finished.set.world_ns = snapshot->world_ns;
    finished.set.monotonic_ns = monotonic_ns;
    for (const View& view : views) {
        for (int k = 0; k < frame::frame_kind_count; ++k) {
            const auto kind = static_cast<frame::FrameKind>(k);
            if (!wants(view, kind)) continue;
            if (kind == frame::FrameKind::sensor) {
                finished.failures.push_back(
                    {view.camera, {ErrorKind::unsupported, "camera " + *view.name + ": a null renderer has no light"}});
                continue;
            }
            if (kind == frame::FrameKind::flow) {
                finished.failures.push_back({view.camera, {ErrorKind::unsupported, no_flow}});
                continue;
            }
            auto frame = acquire_frame(*pool_, view, kind, format_of(kind), snapshot->world_ns, monotonic_ns);
            paint(kind, view, snapshot->world_ns, *frame);
            finished.set.frames.push_back(std::move(frame));
        }
    }
    finished.cost_ns.resize(views.size());
    share_cost(monotonic_now_ns() - start_ns, views, finished.cost_ns);
    return finished;
}

}  // namespace camrig::render
