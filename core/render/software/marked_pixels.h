#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/render/software/geometry.h"
#include "core/render/software/rasterizer.h"

/// Which pixels show more than one surface: those that an edge of an outline touches, and where surfaces cross.
namespace camrig::render::software {

/// A bit for each pixel of some rows, and the set ones numbered from left to right and top to bottom.
class MarkedPixels {
public:
    static constexpr int word_bits = 64;

    /// None is set in rows y0 <= y < y1.
    void clear(int width, int y0, int y1);
    [[gnu::always_inline]] inline void set(int x, int y) {
        row(y)[x / word_bits] |= std::uint64_t{1} << (x % word_bits);
    }
    [[gnu::always_inline]] inline void unset(int x, int y) {
        row(y)[x / word_bits] &= ~(std::uint64_t{1} << (x % word_bits));
    }
    /// To be called when all are set.
    void number();

    /// Takes over the rows that another of the same width has.
    void take(const MarkedPixels& rows);

    int y1() const { return y1_; }
    int words() const { return words_; }
    std::uint32_t count() const { return count_; }
    std::uint64_t* row(int y) { return bits_.data() + offset(y); }
    [[gnu::always_inline]] inline const std::uint64_t* row(int y) const { return bits_.data() + offset(y); }
    [[gnu::always_inline]] inline bool has(int x, int y) const {
        return (row(y)[x / word_bits] >> (x % word_bits) & 1) != 0;
    }
    [[gnu::always_inline]] inline std::uint32_t index_of(int x, int y) const {
        const std::size_t word = offset(y) + static_cast<std::size_t>(x / word_bits);
        const std::uint64_t before = (std::uint64_t{1} << (x % word_bits)) - 1;
        return first_[word] + static_cast<std::uint32_t>(std::popcount(bits_[word] & before));
    }
    /// Calls visit(x, y, index) for all set pixels of a row, from the left.
    template <typename Visit>
    [[gnu::always_inline]] inline void each_of_row(int y, const Visit& visit) const {
        for (int word = 0; word < words_; ++word) {
            std::uint64_t left = row(y)[word];
            std::uint32_t index = first_[offset(y) + static_cast<std::size_t>(word)];
            for (; left != 0; left &= left - 1) visit(word * word_bits + std::countr_zero(left), y, index++);
        }
    }
    /// Calls visit(x, y) for those of a row from x0 up to x1, from the left.
    template <typename Visit>
    [[gnu::always_inline]] inline void each_between(int y, int x0, int x1, const Visit& visit) const {
        const std::uint64_t* const marks = row(y);
        for (int word = x0 / word_bits; word * word_bits < x1; ++word) {
            std::uint64_t left = marks[word];
            if (left == 0) continue;
            const int from = x0 - word * word_bits, till = x1 - word * word_bits;
            if (from > 0) left &= ~std::uint64_t{0} << from;
            if (till < word_bits) left &= (std::uint64_t{1} << till) - 1;
            for (; left != 0; left &= left - 1) visit(word * word_bits + std::countr_zero(left), y);
        }
    }
    std::int64_t bytes() const { return static_cast<std::int64_t>(bits_.size()) * 12; }

private:
    [[gnu::always_inline]] inline std::size_t offset(int y) const {
        return static_cast<std::size_t>(y - y0_) * static_cast<std::size_t>(words_);
    }

    int y0_ = 0, y1_ = 0, words_ = 0;
    std::uint32_t count_ = 0;
    std::vector<std::uint64_t> bits_;
    std::vector<std::uint32_t> first_;  ///< per word
};

/// An edge of a triangle, from 1: that opposite of vertex i.
constexpr std::uint32_t edge_number(std::uint32_t triangle, std::uint32_t i) {
    return triangle * 4 + i + 1;
}
constexpr std::uint32_t triangle_of_edge(std::uint32_t number) {
    return (number - 1) / 4;
}
/// Its ends, as the triangle's corners run.
[[gnu::always_inline]] inline std::pair<const ScreenVertex*, const ScreenVertex*> ends_of_edge(
    const ViewGeometry& geometry, std::uint32_t number) {
    const auto& corners = geometry.triangles()[triangle_of_edge(number)].vertices;
    const std::size_t i = (number - 1) % 4;
    return {&geometry.vertices()[corners[(i + 1) % 3]], &geometry.vertices()[corners[(i + 2) % 3]]};
}
/// Whether two triangles have that edge together, or it is one of them twice.
[[gnu::always_inline]] inline bool is_same_edge(const ViewGeometry& geometry, std::uint32_t a, std::uint32_t b) {
    if (a == b) return true;
    const auto [a_from, a_to] = ends_of_edge(geometry, a);
    const auto [b_from, b_to] = ends_of_edge(geometry, b);
    const auto is_same = [](const ScreenVertex* one, const ScreenVertex* other) {
        return one->x == other->x && one->y == other->y;
    };
    return (is_same(a_from, b_from) && is_same(a_to, b_to)) || (is_same(a_from, b_to) && is_same(a_to, b_from));
}

/// The edges of outlines that go through each pixel, as far as it takes to know that it is one only.
class OutlineEdges {
public:
    static constexpr std::uint32_t none = 0, several = ~0u;

    void fit(ImageSize size) {
        numbers_.fit(size);
        hidden_.fit(size);
    }
    void clear(const PixelRect& rect);

    [[gnu::always_inline]] inline std::uint32_t at(int x, int y) const { return numbers_.rows()(y)[x]; }
    /// The nearest edge in the pixel that its centre hides: the depth it may have; 0: there is none.
    [[gnu::always_inline]] inline float hidden(int x, int y) const { return hidden_.rows()(y)[x]; }
    Rows<std::uint32_t> numbers() const { return numbers_.rows(); }
    Rows<float> hidden() const { return hidden_.rows(); }

private:
    Plane<std::uint32_t> numbers_;
    Plane<float> hidden_;
};

/// What lies behind what a pixel shows by more than this part of its distance is hidden.
inline constexpr float hidden_below = 1.0f - 1.0f / 32.0f;

/// Sets the pixels of the rectangle that edges of outlines touch, where nothing hides them. edges: null if nobody asks
/// which these are.
void mark_outlines(const ViewGeometry& geometry, std::uint32_t first_triangle, std::uint32_t count,
                   const PixelRect& rect, Rows<float> depth, MarkedPixels& to, OutlineEdges* edges = nullptr);

/// Copies the marks of the rectangle's rows, inside of it, and sets the pixels on both sides of a border of surfaces
/// that goes between two unmarked ones: there they cross, or a mask ends. Numbers up to `last_other` are no surface of
/// those that are asked for. Reads the rows beside the rectangle too.
void mark_crossings(const ViewGeometry& geometry, const PixelRect& rect, const MarkedPixels& outlines,
                    const TriangleNumbers& numbers, std::uint32_t last_other, MarkedPixels& to);

}  // namespace camrig::render::software
