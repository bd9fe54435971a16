#include "core/bake/rect_packing.h"

#include <algorithm>
#include <cmath>

#define STB_RECT_PACK_IMPLEMENTATION
#define STBRP_STATIC
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_rect_pack.h>
#pragma GCC diagnostic pop

namespace camrig::bake {

std::optional<std::vector<glm::ivec2>> pack(std::span<const ImageSize> rects, ImageSize area) {
    std::vector<stbrp_rect> list;
    for (std::size_t i = 0; i < rects.size(); ++i)
        list.push_back({static_cast<int>(i), rects[i].width, rects[i].height, 0, 0, 0});
    std::vector<stbrp_node> nodes(static_cast<std::size_t>(area.width));
    stbrp_context context;
    stbrp_init_target(&context, area.width, area.height, nodes.data(), area.width);
    if (stbrp_pack_rects(&context, list.data(), static_cast<int>(list.size())) == 0) return std::nullopt;
    std::vector<glm::ivec2> places(rects.size());
    for (const stbrp_rect& rect : list) places[static_cast<std::size_t>(rect.id)] = {rect.x, rect.y};
    return places;
}

std::optional<PackedRects> pack_tightly(std::span<const ImageSize> rects, int max_side) {
    double area = 0.0;
    int widest = 4;
    for (const ImageSize& rect : rects) {
        area += static_cast<double>(rect.pixels());
        widest = std::max(widest, rect.width);
    }
    const auto in_fours = [](double side) { return (static_cast<int>(std::ceil(side)) + 3) / 4 * 4; };
    for (int width = std::max(in_fours(std::sqrt(area)), in_fours(widest)); width <= max_side;
         width = in_fours(width * 1.1)) {
        auto places = pack(rects, {width, max_side});
        if (!places) continue;
        int height = 4;
        for (std::size_t i = 0; i < rects.size(); ++i) height = std::max(height, (*places)[i].y + rects[i].height);
        if (height > 1.5 * width) continue;
        return PackedRects{{width, in_fours(height)}, std::move(*places)};
    }
    return std::nullopt;
}

}  // namespace camrig::bake
