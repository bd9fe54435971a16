#include "core/render/software/area_work.h"

namespace camrig::render::software {

void StaticPixels::clear(int width, int y0, int y1) {
    marked.clear(width, y0, y1);
    fragments.clear();
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
        for (std::size_t k = 0; k + 1 < from.first.size(); ++k) to.first.push_back(from.first[k] + offset);
    }
    to.marked.number();
    to.first.push_back(static_cast<std::uint32_t>(to.fragments.size()));
    to.fragments.shrink_to_fit();
    to.first.shrink_to_fit();
}

}  // namespace camrig::render::software
