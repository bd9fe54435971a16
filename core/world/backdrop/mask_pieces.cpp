#include "core/world/backdrop/mask_pieces.h"

#include <algorithm>
#include <string>

namespace camrig::world {
namespace {

constexpr int most_px = 16;
constexpr std::size_t most_pieces = 65536;

/// By pixel, whether it is marked.
std::vector<bool> marks_of(const Image& mask) {
    const auto count = static_cast<std::size_t>(mask.size.pixels());
    bool is_opaque = true;
    for (std::size_t i = 0; i < count; ++i) is_opaque &= mask.rgba[4 * i + 3] == 255;
    std::vector<bool> marks(count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint8_t* const pixel = &mask.rgba[4 * i];
        marks[i] = is_opaque ? pixel[0] + pixel[1] + pixel[2] >= 3 * 128 : pixel[3] >= 128;
    }
    return marks;
}

}  // namespace

Result<std::vector<PixelRect>> mask_pieces(const Image& mask) {
    const std::vector<bool> marks = marks_of(mask);
    const auto [width, height] = mask.size;
    std::vector<PixelRect> pieces;
    // Those of the row above, which grow down where the row has the same run.
    std::vector<std::size_t> above, here;
    for (int y = 0; y < height; ++y) {
        here.clear();
        const auto is_marked = [&](int x) { return marks[static_cast<std::size_t>(y) * width + x]; };
        for (int x = 0; x < width;) {
            if (!is_marked(x)) {
                ++x;
                continue;
            }
            const int x0 = x;
            while (x < width && x - x0 < most_px && is_marked(x)) ++x;
            const auto same = std::ranges::find_if(above, [&](std::size_t i) {
                return pieces[i].x0 == x0 && pieces[i].x1 == x && pieces[i].height() < most_px;
            });
            if (same != above.end()) {
                ++pieces[*same].y1;
                here.push_back(*same);
                continue;
            }
            if (pieces.size() == most_pieces)
                return error(ErrorKind::resource_exhausted,
                             "is too ragged: it takes more than " + std::to_string(most_pieces) +
                                 " rectangles; smooth its outline, or leave out single pixels");
            here.push_back(pieces.size());
            pieces.push_back({x0, y, x, y + 1});
        }
        std::swap(above, here);
    }
    if (pieces.empty())
        return error(ErrorKind::invalid_argument,
                     "marks nothing: what shall be cut out has to be opaque or, if all of it is opaque, light");
    return pieces;
}

}  // namespace camrig::world
