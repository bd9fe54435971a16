#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "core/render/software/geometry.h"
#include "core/render/software/rasterizer.h"

/// Which pixels show more than one surface: those that an edge of an outline touches, and where surfaces cross.
namespace camrig {

/// A bit for each pixel of some rows, and the set ones numbered from left to right and top to bottom.
class MarkedPixels {
public:
    static constexpr int word_bits = 64;

    /// None is set in rows y0 <= y < y1.
    void clear(int width, int y0, int y1);
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

/// Sets the pixels of the rectangle that edges of outlines touch, where nothing hides them.
void mark_outlines(const ViewGeometry& geometry, std::uint32_t first_triangle, std::uint32_t count,
                   const PixelRect& rect, Rows<float> depth, MarkedPixels& to);

/// Copies the marks of the rectangle's rows, inside of it, and sets the pixels on both sides of a border of surfaces
/// that goes between two unmarked ones: there they cross, or a mask ends. Numbers up to `last_other` are no surface of
/// those that are asked for. Reads the rows beside the rectangle too.
void mark_crossings(const ViewGeometry& geometry, const PixelRect& rect, const MarkedPixels& outlines,
                    const TriangleNumbers& numbers, std::uint32_t last_other, MarkedPixels& to);

}  // namespace camrig
