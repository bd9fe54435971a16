#include "tools/camrig/dataset/mask_rle.h"

#include <vector>

namespace camrig::cli {
namespace {

/// Lengths of runs, outside and inside of the mask in turns, column by column; the first is outside and may be 0.
struct Runs {
    std::vector<std::int64_t> lengths;
    std::int64_t end = 0;  ///< of the last run inside

    void add(std::int64_t first, std::int64_t last_end) {
        lengths.push_back(first - end);
        lengths.push_back(last_end - first);
        end = last_end;
    }
};

/// Each length as its difference from the one two before (from the fourth on), in groups of five bits with the lowest
/// first, bit 5 for "more follow", 48 added.
std::string compressed(const std::vector<std::int64_t>& lengths) {
    std::string text;
    for (std::size_t i = 0; i < lengths.size(); ++i) {
        std::int64_t value = i > 2 ? lengths[i] - lengths[i - 2] : lengths[i];
        for (bool more = true; more;) {
            std::int64_t group = value & 0x1f;
            value >>= 5;
            more = (group & 0x10) != 0 ? value != -1 : value != 0;  // bit 4 is the sign
            if (more) group |= 0x20;
            text += static_cast<char>(group + 48);
        }
    }
    return text;
}

}  // namespace

std::unordered_map<std::uint32_t, std::string> coco_masks(std::span<const std::uint32_t> ids, ImageSize size) {
    std::unordered_map<std::uint32_t, Runs> runs;
    const std::int64_t pixels = size.pixels();
    std::uint32_t id = 0;
    std::int64_t first = 0, place = 0;
    for (int x = 0; x < size.width; ++x) {
        for (int y = 0; y < size.height; ++y, ++place) {
            const std::uint32_t here =
                ids[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(x)];
            if (here == id) continue;
            if (id != 0) runs[id].add(first, place);
            id = here;
            first = place;
        }
    }
    if (id != 0) runs[id].add(first, pixels);
    std::unordered_map<std::uint32_t, std::string> masks;
    for (auto& [object, of_object] : runs) {
        if (of_object.end < pixels) of_object.lengths.push_back(pixels - of_object.end);
        masks[object] = compressed(of_object.lengths);
    }
    return masks;
}

}  // namespace camrig::cli
