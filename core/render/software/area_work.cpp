#include "core/render/software/area_work.h"

namespace camrig::render::software {

void StaticPixels::clear(int width, int y0, int y1) {
    marked.clear(width, y0, y1);
    fragments.clear();
    lit_colors.clear();
    place_of_fragment.clear();
    places.clear();
    positions.clear();
    first.assign(1, 0);
}

void AreaScratch::begin(ImageSize size, int count) {
    outlines.clear(size.width, 0, size.height);
    edges.fit(size);
    while (bands.size() < static_cast<std::size_t>(count)) bands.emplace_back();
    band_count = count;
    statics_behind.fit(size);
    shown_behind.fit(size);
    depth_behind.fit(size);
}

void AreaScratch::gather(StaticPixels& to) const {
    const MarkedPixels& last = bands[static_cast<std::size_t>(band_count) - 1].statics.marked;
    to.clear(last.words() * MarkedPixels::word_bits, 0, last.y1());
    to.first.clear();
    for (int i = 0; i < band_count; ++i) {
        const StaticPixels& from = bands[static_cast<std::size_t>(i)].statics;
        const auto offset = static_cast<std::uint32_t>(to.fragments.size());
        to.marked.take(from.marked);
        to.fragments.insert(to.fragments.end(), from.fragments.begin(), from.fragments.end());
        to.lit_colors.insert(to.lit_colors.end(), from.lit_colors.begin(), from.lit_colors.end());
        const auto place_offset = static_cast<std::uint32_t>(to.places.size());
        for (const std::uint32_t place : from.place_of_fragment)
            to.place_of_fragment.push_back(place == no_place ? no_place : place + place_offset);
        to.places.insert(to.places.end(), from.places.begin(), from.places.end());
        to.positions.insert(to.positions.end(), from.positions.begin(), from.positions.end());
        for (std::size_t k = 0; k + 1 < from.first.size(); ++k) to.first.push_back(from.first[k] + offset);
    }
    to.marked.number();
    to.first.push_back(static_cast<std::uint32_t>(to.fragments.size()));
    to.fragments.shrink_to_fit();
    to.first.shrink_to_fit();
    to.lit_colors.shrink_to_fit();
    to.place_of_fragment.shrink_to_fit();
    to.places.shrink_to_fit();
    to.positions.shrink_to_fit();
}

}  // namespace camrig::render::software
