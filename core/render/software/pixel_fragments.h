#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/render/software/geometry.h"
#include "core/render/software/marked_pixels.h"
#include "core/render/software/pixel_part.h"

/// The parts of triangles that marked pixels show.
namespace camrig::render::software {

/// What of a pixel one triangle covers.
struct Fragment {
    SampleMask mask = 0;
    PixelPlane plane;
    float reach = 0.0f;          ///< of the plane
    std::uint32_t triangle = 0;  ///< into ViewGeometry::triangles
    std::uint32_t next = 0;      ///< of the same pixel, from 1; 0: none
};

/// The fragments of each marked pixel, in the order of the triangles. What is certainly hidden by another one may be
/// left out.
class PixelFragments {
public:
    /// hides: what lies in front is opaque. If not, a pixel takes most_fragments and is full with one more.
    explicit PixelFragments(bool hides = true) : hides_(hides) {}
    static constexpr int most_fragments = 128;
    void clear(std::uint32_t pixels) {
        lists_.assign(pixels, {});
        if (!hides_) counts_.assign(pixels, 0);
        fragments_.clear();
    }
    /// Calls visit(fragment) for those of a marked pixel.
    template <typename Visit>
    [[gnu::always_inline]] inline void each_of(std::uint32_t pixel, const Visit& visit) const {
        for (std::uint32_t at = lists_[pixel].first; at != 0; at = fragments_[at - 1].next) visit(fragments_[at - 1]);
    }
    [[gnu::always_inline]] inline bool has(std::uint32_t pixel) const { return lists_[pixel].first != 0; }

    bool is_full(std::uint32_t pixel) const { return counts_[pixel] > most_fragments; }
    /// Whether nothing hides so much depth in the whole pixel.
    [[gnu::always_inline]] inline bool may_show(std::uint32_t pixel, float nearest) const {
        return nearest >= lists_[pixel].hidden_below;
    }
    /// The places of a pixel where no fragment so far certainly hides so much depth.
    [[gnu::always_inline]] inline SampleMask open_places(std::uint32_t pixel, float nearest) const {
        const List& list = lists_[pixel];
        return nearest < list.covered_before ? ~list.covered : all_samples;
    }
    [[gnu::always_inline]] inline void add(std::uint32_t pixel, SampleMask mask, const PixelPlane& plane, float reach,
                                           std::uint32_t triangle) {
        Fragment& made = fragments_.emplace_back();
        made.mask = mask;
        made.plane.z = plane.z;
        made.plane.dx = plane.dx;
        made.plane.dy = plane.dy;
        made.reach = reach;
        made.triangle = triangle;
        const auto number = static_cast<std::uint32_t>(fragments_.size());
        List& list = lists_[pixel];
        (list.last == 0 ? list.first : fragments_[list.last - 1].next) = number;
        list.last = number;
        if (!hides_) {
            // Nothing more may show.
            if (++counts_[pixel] > most_fragments) list.hidden_below = std::numeric_limits<float>::infinity();
            return;
        }
        const float farthest = plane.z - reach;
        list.covered_before = list.covered == 0 ? farthest : std::min(list.covered_before, farthest);
        list.covered |= mask;
        if (mask == all_samples) list.hidden_below = std::max(list.hidden_below, farthest);
        if (list.covered != all_samples) return;
        list.hidden_below = std::max(list.hidden_below, list.covered_before);
        list.covered = 0;
    }
    /// Of find_fragments: a triangle that comes later, the nearer the sooner.
    struct Later {
        float rank;  ///< the depth of its nearest corner, negative
        std::uint32_t triangle;
        auto operator<=>(const Later&) const = default;
    };
    std::vector<Later> later;

private:
    struct List {
        std::uint32_t first = 0, last = 0;
        float hidden_below = 0.0f;
        float covered_before = 0.0f;  ///< at least so deep is what covers the places of `covered`
        SampleMask covered = 0;
    };
    bool hides_;
    std::vector<std::uint8_t> counts_;  ///< how many fragments each pixel has, if they hide nothing
    std::vector<List> lists_;
    std::vector<Fragment> fragments_;
};

/// Adds what these triangles cover of the marked pixels of the rectangle. Edges that triangles share divide the samples
/// of a pixel with none left and none twice: they are weighed in whole numbers, as in coverage.h.
void find_fragments(const ViewGeometry& geometry, std::uint32_t first_triangle, std::uint32_t count,
                    const PixelRect& rect, const MarkedPixels& marked, PixelFragments& to);

}  // namespace camrig::render::software
