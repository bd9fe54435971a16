#pragma once

#include <cstdint>
#include <vector>

#include "core/base/pixel_rect.h"
#include "core/world/model.h"

namespace camrig::world {

/// A picture of which only parts are there, kept in square blocks: as large as no memory would be for all of it.
/// What is put beside each other has no seam: there is one grid of pixels.
class SparsePicture {
public:
    static constexpr int block_side = 256;
    static constexpr std::size_t block_bytes = std::size_t{4} * block_side * block_side;

    /// Nothing of it is there.
    explicit SparsePicture(ImageSize size);

    ImageSize size() const { return size_; }
    /// RGBA, opaque; null: the pixel is not there. Within the size.
    const std::uint8_t* at(int x, int y) const {
        const std::int32_t block = block_of_[index_of(x / block_side, y / block_side)];
        if (block < 0 || blocks_[static_cast<std::size_t>(block)].empty()) return nullptr;
        const std::uint8_t* const pixel = blocks_[static_cast<std::size_t>(block)].data() +
                                          4 * static_cast<std::size_t>((y % block_side) * block_side + x % block_side);
        return pixel[3] != 0 ? pixel : nullptr;
    }

    /// How many bytes more it will take once something is put into this rectangle, too. Within the size.
    std::size_t bytes_of(const PixelRect& rect) const;
    /// Something will be put there. Takes no memory yet.
    void reserve(const PixelRect& rect);
    /// Copies the columns of the picture from `first` on to `to`, whose size they have at least and which is reserved.
    /// What is not wholly opaque is left out.
    void put(const Image& picture, int first, const PixelRect& to);
    /// Puts the mean of each four pixels of the double picture, in linear light, where all four are there and nothing
    /// is yet. Where they are has been reserved.
    void fill_from(const SparsePicture& twice);

private:
    std::size_t index_of(int column, int row) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
    }
    std::vector<std::uint8_t>& block_at(std::int32_t number);
    Image block_from(const SparsePicture& twice, int column, int row) const;

    ImageSize size_;
    int columns_ = 0;                     ///< of blocks
    std::vector<std::int32_t> block_of_;  ///< of each place; -1: none
    std::vector<std::vector<std::uint8_t>> blocks_;
};

}  // namespace camrig::world
