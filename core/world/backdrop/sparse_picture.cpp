#include "core/world/backdrop/sparse_picture.h"

#include <algorithm>
#include <cstring>

#include "core/world/backdrop/scale_picture.h"

namespace camrig::world {
namespace {

/// The blocks that the rectangle touches.
template <typename Fn>
void each_block(const PixelRect& rect, const Fn& fn) {
    constexpr int side = SparsePicture::block_side;
    if (rect.area() == 0) return;
    for (int row = rect.y0 / side; row <= (rect.y1 - 1) / side; ++row)
        for (int column = rect.x0 / side; column <= (rect.x1 - 1) / side; ++column) fn(column, row);
}

std::uint8_t* pixel_in(std::vector<std::uint8_t>& block, int x, int y) {
    return block.data() + 4 * static_cast<std::size_t>(y * SparsePicture::block_side + x);
}

}  // namespace

SparsePicture::SparsePicture(ImageSize size) : size_(size), columns_((size.width + block_side - 1) / block_side) {
    block_of_.assign(index_of(0, (size.height + block_side - 1) / block_side), -1);
}

std::size_t SparsePicture::bytes_of(const PixelRect& rect) const {
    std::size_t bytes = 0;
    each_block(rect, [&](int column, int row) {
        if (block_of_[index_of(column, row)] < 0) bytes += block_bytes;
    });
    return bytes;
}

void SparsePicture::reserve(const PixelRect& rect) {
    each_block(rect, [&](int column, int row) {
        std::int32_t& block = block_of_[index_of(column, row)];
        if (block >= 0) return;
        block = static_cast<std::int32_t>(blocks_.size());
        blocks_.emplace_back();
    });
}

std::vector<std::uint8_t>& SparsePicture::block_at(std::int32_t number) {
    std::vector<std::uint8_t>& block = blocks_[static_cast<std::size_t>(number)];
    if (block.empty()) block.resize(block_bytes);
    return block;
}

void SparsePicture::put(const Image& picture, int first, const PixelRect& to) {
    each_block(to, [&](int column, int row) {
        std::vector<std::uint8_t>& block = block_at(block_of_[index_of(column, row)]);
        const int left = std::max(to.x0, column * block_side), right = std::min(to.x1, (column + 1) * block_side);
        for (int y = std::max(to.y0, row * block_side); y < std::min(to.y1, (row + 1) * block_side); ++y) {
            const std::uint8_t* from = picture.rgba.data() + 4 * (static_cast<std::size_t>(y - to.y0) *
                                                                      static_cast<std::size_t>(picture.size.width) +
                                                                  static_cast<std::size_t>(first + left - to.x0));
            std::uint8_t* at = pixel_in(block, left % block_side, y % block_side);
            for (int x = left; x < right; ++x, from += 4, at += 4)
                if (from[3] == 255) std::memcpy(at, from, 4);
        }
    });
}

Image SparsePicture::block_from(const SparsePicture& twice, int column, int row) const {
    Image four{.size = {2 * block_side, 2 * block_side}, .rgba = std::vector<std::uint8_t>(4 * block_bytes)};
    const int left = 2 * block_side * column, top = 2 * block_side * row;
    for (int y = 0; y < std::min(2 * block_side, twice.size_.height - top); ++y)
        for (int x = 0; x < std::min(2 * block_side, twice.size_.width - left); ++x)
            if (const std::uint8_t* const from = twice.at(left + x, top + y))
                std::memcpy(four.rgba.data() + 4 * static_cast<std::size_t>(y * 2 * block_side + x), from, 4);
    return four;
}

void SparsePicture::fill_from(const SparsePicture& twice) {
    each_block({0, 0, size_.width, size_.height}, [&](int column, int row) {
        const std::int32_t number = block_of_[index_of(column, row)];
        if (number < 0) return;
        std::vector<std::uint8_t>& block = block_at(number);
        const Image four = block_from(twice, column, row);
        const Image mean = scaled_picture(four, {block_side, block_side});
        const auto is_there = [&](int x, int y) {
            return four.rgba[4 * static_cast<std::size_t>(y * 2 * block_side + x) + 3] != 0;
        };
        for (int y = 0; y < block_side; ++y) {
            for (int x = 0; x < block_side; ++x) {
                std::uint8_t* const at = pixel_in(block, x, y);
                if (at[3] != 0 || !is_there(2 * x, 2 * y) || !is_there(2 * x + 1, 2 * y) ||
                    !is_there(2 * x, 2 * y + 1) || !is_there(2 * x + 1, 2 * y + 1))
                    continue;
                std::memcpy(at, mean.rgba.data() + 4 * static_cast<std::size_t>(y * block_side + x), 4);
            }
        }
    });
}

}  // namespace camrig::world
