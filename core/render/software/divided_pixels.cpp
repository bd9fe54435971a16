#include "core/render/software/divided_pixels.h"

#include <algorithm>
#include <cstdlib>
#include <optional>

#include "core/render/software/sample_places.h"

namespace camrig::render::software {
namespace {

/// An edge of a triangle, which lies where its values are not negative.
struct DividingEdge {
    std::uint32_t triangle;
    std::int32_t dx, dy;
    std::int64_t value;  ///< at the middle of the pixel

    CAMRIG_LANES DividingEdge(const ViewGeometry& geometry, std::uint32_t number, int x, int y)
        : triangle(triangle_of_edge(number)) {
        const auto [from, to] = ends_of_edge(geometry, number);
        dx = to->x - from->x;
        dy = to->y - from->y;
        const bool is_top_left = dy < 0 || (dy == 0 && dx > 0);
        value = std::int64_t{dx} * (y * subpixels - from->y) - std::int64_t{dy} * (x * subpixels - from->x) -
                (is_top_left ? 0 : 1);
    }

    CAMRIG_LANES bool has_middle() const { return value >= 0; }

    template <typename Isa>
    CAMRIG_LANES SampleMask places_with_middle() const {
        const std::int64_t reach =
            std::int64_t{offset_in_subpixels * most_offset} * (std::abs(std::int64_t{dx}) + std::abs(std::int64_t{dy}));
        if (value >= reach || value < -reach) return all_samples;
        const SampleMask inside = ~places_outside<Isa>(dx, dy, value);
        return has_middle() ? inside : ~inside;
    }
};

/// To the next pixel, across an edge.
struct Step {
    int x, y;
};
CAMRIG_LANES Step across(const DividingEdge& edge) {
    const int out = edge.has_middle() ? -1 : 1;
    if (std::abs(edge.dy) >= std::abs(edge.dx)) return {edge.dy > 0 ? -out : out, 0};
    return {0, edge.dx > 0 ? out : -out};
}

class Divider {
public:
    Divider(const ViewGeometry& geometry, const PixelRect& drawn, const OutlineEdges& edges,
            Rows<std::uint32_t> numbers, Rows<float> depth)
        : geometry_(geometry), drawn_(drawn), edges_(edges), numbers_(numbers), depth_(depth) {}

    /// None: the pixel is crowded.
    template <typename Isa>
    CAMRIG_LANES std::optional<DividedPixel> divided(int x, int y) const {
        const std::uint32_t number = edges_.at(x, y);
        if (number == OutlineEdges::none || number == OutlineEdges::several) return {};
        const DividingEdge edge(geometry_, number, x, y);
        const Step step = across(edge);
        const int next_x = x + step.x, next_y = y + step.y;
        if (next_x < drawn_.x0 || next_x >= drawn_.x1 || next_y < drawn_.y0 || next_y >= drawn_.y1) return {};
        const std::int64_t beyond = edge.value + std::int64_t{subpixels} * (step.y * edge.dx - step.x * edge.dy);
        if ((beyond >= 0) == edge.has_middle()) return {};
        const std::uint32_t next_number = edges_.at(next_x, next_y);
        if (next_number == OutlineEdges::several) return {};
        if (next_number != OutlineEdges::none && !is_same_edge(geometry_, number, next_number)) return {};
        const std::uint32_t own = numbers_(y)[x], next = numbers_(next_y)[next_x];
        const std::uint32_t within = edge.has_middle() ? own : next;
        if (own == next || within == 0 || !is_one_surface(within - 1, edge.triangle)) return {};
        if (has_mask(own) || has_mask(next)) return {};
        // What the middle hides may show beyond the edge.
        const float hidden = edges_.hidden(x, y);
        if (edge.has_middle() && hidden > 0.0f && hidden >= depth_(next_y)[next_x] * hidden_below) return {};
        return DividedPixel{edge.places_with_middle<Isa>(), next};
    }

private:
    CAMRIG_LANES std::uint32_t draw_of(std::uint32_t number) const { return geometry_.triangles()[number - 1].draw; }
    CAMRIG_LANES bool is_one_surface(std::uint32_t a, std::uint32_t b) const {
        if (a == b) return true;
        const auto &one = geometry_.triangles()[a], &other = geometry_.triangles()[b];
        return one.draw == other.draw && std::ranges::find_first_of(one.vertices, other.vertices) != one.vertices.end();
    }
    CAMRIG_LANES bool has_mask(std::uint32_t number) const {
        return number != 0 &&
               geometry_.draws()[draw_of(number)].primitive->material->alpha_mode == world::AlphaMode::mask;
    }

    const ViewGeometry& geometry_;
    PixelRect drawn_;
    const OutlineEdges& edges_;
    Rows<std::uint32_t> numbers_;
    Rows<float> depth_;
};

template <typename Isa>
CAMRIG_LANES void find_divided_body(const Divider& divider, const PixelRect& rect, const MarkedPixels& marked,
                                    MarkedPixels& crowded, std::vector<DividedPixel>& divided) {
    for (int y = rect.y0; y < rect.y1; ++y) {
        marked.each_of_row(y, [&](int x, int, std::uint32_t) __attribute__((always_inline)) {
            if (const auto made = divider.divided<Isa>(x, y)) {
                divided.push_back(*made);
            } else {
                crowded.set(x, y);
            }
        });
    }
}
CAMRIG_WIDE void find_divided_wide(const Divider& divider, const PixelRect& rect, const MarkedPixels& marked,
                                   MarkedPixels& crowded, std::vector<DividedPixel>& divided) {
    find_divided_body<Avx2Isa>(divider, rect, marked, crowded, divided);
}

}  // namespace

void find_divided(const ViewGeometry& geometry, const PixelRect& rect, const PixelRect& drawn,
                  const MarkedPixels& marked, const OutlineEdges& edges, Rows<std::uint32_t> numbers, Rows<float> depth,
                  MarkedPixels& crowded, std::vector<DividedPixel>& divided) {
    const Divider divider(geometry, drawn, edges, numbers, depth);
    if (geometry.wide_lanes()) return find_divided_wide(divider, rect, marked, crowded, divided);
    find_divided_body<PlainIsa>(divider, rect, marked, crowded, divided);
}

}  // namespace camrig::render::software
