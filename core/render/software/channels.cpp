#include "core/render/software/channels.h"

#include <bit>
#include <cmath>
#include <limits>

#include "core/render/software/depth_of_pixels.h"
#include "core/render/software/flow.h"
#include "core/render/software/rows.h"
#include "core/render/software/shading.h"
#include "core/render/software/surface_point.h"
#include "core/render/software/view_rows.h"

namespace camrig::render::software {
namespace {

ChannelFrame& channel_of(ViewWork& work, frame::FrameKind kind) {
    return work.channels[index_of(kind)];
}

/// Of words.
Rows<std::uint32_t> rows_of(const ChannelFrame& channel) {
    const frame::FrameInfo& info = channel.frame->info();
    return {reinterpret_cast<std::uint32_t*>(channel.frame->mutable_bytes().data()),
            words_of(info.kind) * info.size.width};
}

PixelRect in_words(frame::FrameKind kind, PixelRect rect) {
    rect.x0 *= words_of(kind);
    rect.x1 *= words_of(kind);
    return rect;
}

/// Of what shows nothing.
std::uint32_t nothing_of(frame::FrameKind kind) {
    using Float = std::numeric_limits<float>;
    if (kind == frame::FrameKind::depth) return std::bit_cast<std::uint32_t>(Float::infinity());
    return kind == frame::FrameKind::flow ? std::bit_cast<std::uint32_t>(Float::quiet_NaN()) : 0;
}

CAMRIG_LANES Lanes metres_at(const LensRays* rays, const DepthOfPixels& of, int x, int y) {
    // Seen from its edge it may have no depth there.
    const auto limited = [&](Lanes metres) __attribute__((always_inline)) {
        const Lanes not_nearer = metres > of.nearest ? metres : lanes(of.nearest);
        return not_nearer < of.farthest ? not_nearer : lanes(of.farthest);
    };
    if (rays == nullptr) {
        const Doubles columns = widened(int_lane_numbers() + x);
        return limited(narrowed(of.offset / (columns * of.right + (y * of.down + of.ahead))));
    }
    const Lanes3 ray = rays_at(*rays, x, y);
    const Doubles across = widened(ray.x) * of.right + widened(ray.y) * of.down + widened(ray.z) * of.ahead;
    return limited(narrowed(of.offset / across)) * ray.z;
}

/// Of a group that may reach beyond the row.
CAMRIG_LANES void put(std::uint32_t* row, int x, int width, IntLanes mask, IntLanes values) {
    if (x + lane_count <= width) return store(row, x, mask, values);
    for (int k = 0; k < width - x; ++k)
        if (mask[k] != 0) row[x + k] = static_cast<std::uint32_t>(values[k]);
}

/// Normals of a draw in the optical frame, as shaders/truth.frag: those of the vertices, turned round where the back is
/// seen; towards the camera where a vertex has none.
template <typename Isa>
CAMRIG_LANES Lanes3 normals_at(const ViewDraw& draw, const TriangleOfEach<Isa>& triangles, int x, int y) {
    Lanes3 n{Lanes{}, Lanes{}, lanes(-1.0f)};
    if (draw.normals != nullptr) {
        const PointOnTriangle place = place_at(triangles, x, y);
        const CornerAttribute attribute{&draw.normals->x, 3, offsetof(VertexValues, normal)};
        const std::array<Lanes, 3> a = triangles.template values<3>(0, attribute);
        const std::array<Lanes, 3> b = triangles.template values<3>(1, attribute);
        const std::array<Lanes, 3> c = triangles.template values<3>(2, attribute);
        const auto local = [&](std::size_t i) __attribute__((always_inline)) {
            return a[i] + place.second * (b[i] - a[i]) + place.third * (c[i] - a[i]);
        };
        const glm::mat3& m = draw.optical_from_normal;
        const Lanes3 v = splat(m[0]) * local(0) + splat(m[1]) * local(1) + splat(m[2]) * local(2);
        const Lanes length2 = dot(v, v);
        const IntLanes is_there = length2 > 0.0f;
        const Lanes inverse = 1.0f / sqrt(is_there ? length2 : lanes(1.0f));
        n = {is_there ? v.x * inverse : n.x, is_there ? v.y * inverse : n.y, is_there ? v.z * inverse : n.z};
    }
    return {triangles.where_front(n.x, -n.x), triangles.where_front(n.y, -n.y), triangles.where_front(n.z, -n.z)};
}

template <typename Isa>
CAMRIG_LANES void describe_body(const ViewScratch& scratch, const PixelRect& rect, ViewWork& work) {
    const ViewGeometry& geometry = scratch.geometry;
    const Rows<std::uint32_t> numbers = scratch.numbers.rows();
    const auto target = [&](frame::FrameKind kind) {
        const ChannelFrame& channel = channel_of(work, kind);
        return channel.frame != nullptr ? rows_of(channel) : Rows<std::uint32_t>{};
    };
    const Rows<std::uint32_t> depths = target(frame::FrameKind::depth), ids = target(frame::FrameKind::instance),
                              classes = target(frame::FrameKind::semantic), normals = target(frame::FrameKind::normal);
    std::int32_t last = 0;  // the triangle that `depth` is of
    DepthOfPixels depth;
    for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0 & -lane_count; x < rect.x1; x += lane_count) {
            const IntLanes number = *reinterpret_cast<const IntLanes*>(numbers(y) + x);
            const IntLanes drawn = number != 0;
            unsigned left = Isa::bits(drawn);
            if (left == 0) continue;
            const IntLanes draws = draws_of<Isa>(geometry.triangles().data(), number);
            const auto name = [&](const Rows<std::uint32_t>& rows, const std::vector<std::int32_t>& of_draws)
                                  __attribute__((always_inline)) {
                                      if (rows.data != nullptr)
                                          put(rows(y), x, work.whole.x1, drawn, gathered<Isa>(of_draws.data(), draws));
                                  };
            name(ids, scratch.ids_of_draws);
            name(classes, scratch.classes_of_draws);
            if (depths.data != nullptr) {
                Lanes metres{};
                for (unsigned open = left; open != 0;) {
                    const std::int32_t of = number[std::countr_zero(open)];
                    if (of != last) depth = depth_of(geometry, geometry.triangles()[static_cast<std::size_t>(of - 1)]);
                    last = of;
                    const IntLanes mask = number == of;
                    metres = mask ? metres_at(geometry.rays(), depth, x, y) : metres;
                    open &= ~Isa::bits(mask);
                }
                put(depths(y), x, work.whole.x1, drawn, reinterpret_cast<IntLanes>(metres));
            }
            if (normals.data == nullptr) continue;
            while (left != 0) {
                const int first = std::countr_zero(left);
                const ViewDraw& draw = geometry.draws()[static_cast<std::size_t>(draws[first])];
                const IntLanes mask = drawn & (draws == draws[first]);
                const IntLanes own = mask ? number : IntLanes{} + number[first];
                const Lanes3 n = normals_at<Isa>(draw, TriangleOfEach<Isa>(geometry, draw, own), x, y);
                for (unsigned these = Isa::bits(mask); these != 0; these &= these - 1) {
                    const int k = std::countr_zero(these);
                    const std::array<float, 3> made{n.x[k], n.y[k], n.z[k]};
                    std::memcpy(normals(y) + std::ptrdiff_t{3} * (x + k), made.data(), sizeof made);
                }
                left &= ~Isa::bits(mask);
            }
        }
    }
}

CAMRIG_WIDE void describe_wide(const ViewScratch& scratch, const PixelRect& rect, ViewWork& work) {
    describe_body<Avx2Isa>(scratch, rect, work);
}

/// What shows of these triangles, in the channels.
void draw_opaque(const TriangleRange& triangles, ViewWork& work, const ViewScratch& scratch, const PixelRect& band) {
    if (triangles.count == 0 || work.rects.empty()) return;
    const PixelRect hull = common(hull_of(work.rects), band);
    if (hull.height() <= 0) return;
    find_visible(scratch.geometry, triangles.first, triangles.count, hull, work.canvas, scratch.numbers);
    for (const PixelRect& rect : work.rects) {
        describe_visible(scratch, common(rect, band), work);
        fill(scratch.numbers.rows(), common(rect, band), 0u);
    }
}

}  // namespace

void name_draws(ViewScratch& scratch) {
    scratch.ids_of_draws.clear();
    scratch.classes_of_draws.clear();
    for (const ViewDraw& draw : scratch.geometry.draws()) {
        const world::ObjectInfo& object = *draw.placed->object;
        scratch.ids_of_draws.push_back(static_cast<std::int32_t>(object.id));
        scratch.classes_of_draws.push_back(static_cast<std::int32_t>(object.class_number));
    }
}

void begin_channels(ViewWork& work, const PixelRect& band) {
    for (const frame::FrameKind kind : channel_kinds) {
        const ChannelFrame& channel = channel_of(work, kind);
        if (channel.frame == nullptr) continue;
        if (!work.is_in_parts) {
            fill(rows_of(channel), in_words(kind, band), nothing_of(kind));
            continue;
        }
        const Rows<std::uint32_t> kept = work.layer->channels[index_of(kind)].rows();
        const auto put_back = [&](std::span<const PixelRect> rects) {
            for (const PixelRect& rect : rects) copy(kept, rows_of(channel), in_words(kind, common(rect, band)));
        };
        put_back(channel.stale);
        put_back(work.rects);
    }
}

void describe_visible(const ViewScratch& scratch, const PixelRect& rect, ViewWork& work) {
    if (std::ranges::none_of(work.channels, [](const ChannelFrame& channel) { return channel.frame != nullptr; }))
        return;
    if (work.ahead != nullptr) describe_flow(scratch, rect, work);
    if (scratch.geometry.wide_lanes()) return describe_wide(scratch, rect, work);
    describe_body<PlainIsa>(scratch, rect, work);
}

void keep_channels(ViewWork& work, const PixelRect& band) {
    for (const frame::FrameKind kind : channel_kinds) {
        const ChannelFrame& channel = channel_of(work, kind);
        if (channel.frame == nullptr) continue;
        copy(rows_of(channel), work.layer->channels[index_of(kind)].rows(), in_words(kind, band));
    }
}

void draw_channel_rows(ViewWork& work, const ViewScratch& scratch, const PixelRect& band) {
    begin_channels(work, band);
    if (work.is_in_parts) {
        for (const PixelRect& rect : work.rects) copy(work.layer->depth.rows(), work.canvas.depth, common(rect, band));
    } else {
        fill(work.canvas.depth, band, 0.0f);
        cover_blind(work.scene, work.canvas, band);
    }
    if (work.layer != nullptr && !work.is_in_parts) {
        draw_opaque(scratch.statics, work, scratch, band);
        copy(work.canvas.depth, work.layer->depth.rows(), band);
        keep_channels(work, band);
    }
    draw_opaque(scratch.movers, work, scratch, band);
}

}  // namespace camrig::render::software
