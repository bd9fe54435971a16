#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/image_size.h"
#include "core/base/pixel_rect.h"

namespace camrig {

/// Which tiles of a picture are marked: squares of 16 pixels, from its top left corner on.
class TileSet {
public:
    static constexpr int side = 16;

    /// None of a picture of that size.
    void clear(ImageSize size) {
        size_ = size;
        words_ = (tiles_of(size.width) + word_bits - 1) / word_bits;
        bits_.assign(static_cast<std::size_t>(words_ * tiles_of(size.height)), 0);
    }

    /// Marks all that a rectangle within the picture touches. Adds the pixels of those that were not marked before.
    void mark(const PixelRect& rect, std::vector<PixelRect>& added) {
        if (rect.width() <= 0 || rect.height() <= 0) return;
        const int end = tiles_of(rect.x1);
        for (int row = rect.y0 / side; row < tiles_of(rect.y1); ++row) {
            for (int tile = rect.x0 / side; tile < end; ++tile) {
                if (has(row, tile)) continue;
                const int first = tile;
                for (; tile < end && !has(row, tile); ++tile) word(row, tile) |= bit(tile);
                added.push_back({first * side, row * side, std::min(tile * side, size_.width),
                                 std::min((row + 1) * side, size_.height)});
            }
        }
    }

    /// Calls visit(x0, x1) for marked pixels x0 <= x < x1 of a row, from the left, each once.
    template <typename Visit>
    void each_run(int y, const Visit& visit) const {
        const std::uint64_t* const row = bits_.data() + std::ptrdiff_t{y / side} * words_;
        for (int w = 0; w < words_; ++w) {
            std::uint64_t left = row[w];
            while (left != 0) {
                const int first = std::countr_zero(left), count = std::countr_one(left >> first);
                left = first + count == word_bits ? 0 : left >> (first + count) << (first + count);
                visit((w * word_bits + first) * side, std::min((w * word_bits + first + count) * side, size_.width));
            }
        }
    }

private:
    static constexpr int word_bits = 64;
    static int tiles_of(int pixels) { return (pixels + side - 1) / side; }
    static std::uint64_t bit(int tile) { return std::uint64_t{1} << (tile % word_bits); }
    std::uint64_t& word(int row, int tile) { return bits_[static_cast<std::size_t>(row * words_ + tile / word_bits)]; }
    bool has(int row, int tile) { return (word(row, tile) & bit(tile)) != 0; }

    ImageSize size_;
    int words_ = 0;
    std::vector<std::uint64_t> bits_;
};

}  // namespace camrig
