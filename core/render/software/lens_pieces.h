#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/render/software/lens_numbers.h"
#include "core/render/software/screen_triangles.h"

namespace camrig {

/// A triangle in pieces whose edges a lens shows straight (LensView::max_sag_px), cut at the near plane and far beside
/// what is seen.
///
/// Whether an edge is divided, and where, follows from its two ends alone, whichever comes first: what shares an edge
/// stays watertight. Each piece is divided at the middles of its bent edges, as they appear, again and again; what lies
/// outside of what is seen is dropped on the way. At most max_depth times, and no more once a view has max_pieces.
class LensPieces {
public:
    static constexpr int max_depth = 12;
    static constexpr std::uint32_t max_pieces = 1u << 20;

    struct Point {
        glm::dvec3 p;       ///< in the optical frame
        glm::dvec3 shares;  ///< of the corners of the triangle
        double w;           ///< what is interpolated along, in metres: z, or the distance from the eye
        glm::dvec2 px;
        glm::vec2 ideal;
        float radius;  ///< of ideal
    };

    void begin_view(const LensView& lens, const ViewTransform& view);
    const LensNumbers& numbers() const { return numbers_; }
    /// Divides a triangle, given in the optical frame; the results are good until the next call.
    void divide(const std::array<glm::dvec3, 3>& corners);
    /// The corners first, then those that were made.
    std::span<const Point> points() const { return points_; }
    /// Corners of pieces, into points().
    std::span<const std::array<std::uint32_t, 3>> pieces() const { return pieces_; }
    ScreenVertex on_screen(const Point& point) const;

private:
    /// How often more an edge is bent than may be; not_known: nobody looked.
    static constexpr float not_known = -1.0f;
    struct Piece {
        std::array<std::uint32_t, 3> at;
        std::array<float, 3> bend;  ///< of the edge from this corner to the next
    };
    struct Edge {
        float bend = 0.0f;
        float length2 = 0.0f;   ///< on the ideal plane
        float shift_px = 0.0f;  ///< how far its middle lies from the middle of its ends
        bool is_long = false;   ///< too long to tell its bend from its middle
        bool has_joint = false, is_bent = false;
        Point middle;
    };
    Point point_at(const glm::dvec3& p, const glm::dvec3& shares) const;
    Edge look_at(std::uint32_t from, std::uint32_t to, float bend) const;
    void divide(const Piece& piece, int depth);
    bool is_outside(const Piece& piece, const std::array<Edge, 3>& edges) const;
    bool is_beyond_end(const Piece& piece) const;
    /// Keeps of a polygon, points_ of these numbers, what has no negative height.
    template <typename Height>
    void cut(std::vector<std::uint32_t>& polygon, const Height& height);
    /// Unless nothing of it is seen.
    void add(const Piece& piece);

    const LensView* lens_ = nullptr;
    LensNumbers numbers_;
    ImageSize size_;
    float simple_share_ = 0.0f;
    std::uint32_t made_ = 0;  ///< pieces of this view
    std::vector<Point> points_;
    std::vector<std::array<std::uint32_t, 3>> pieces_;
    std::vector<std::uint32_t> polygon_, kept_;
};

}  // namespace camrig
