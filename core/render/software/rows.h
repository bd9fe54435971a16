#pragma once

#include <algorithm>
#include <cstring>
#include <span>

#include "core/render/pixel_rect.h"
#include "core/render/software/canvas.h"

/// Rectangles of planes and frames.
namespace camrig::render::software {

/// May be of less than no height.
inline PixelRect common(const PixelRect& a, const PixelRect& b) {
    return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

inline PixelRect grown(const PixelRect& rect, int by) {
    return {rect.x0 - by, rect.y0 - by, rect.x1 + by, rect.y1 + by};
}

inline PixelRect hull_of(std::span<const PixelRect> rects) {
    PixelRect hull = rects.front();
    for (const PixelRect& rect : rects)
        hull = {std::min(hull.x0, rect.x0), std::min(hull.y0, rect.y0), std::max(hull.x1, rect.x1),
                std::max(hull.y1, rect.y1)};
    return hull;
}

template <typename T>
void copy(Rows<T> from, Rows<T> to, const PixelRect& rect) {
    if (rect.width() <= 0) return;
    const auto bytes = static_cast<std::size_t>(rect.width()) * sizeof(T);
    for (int y = rect.y0; y < rect.y1; ++y) std::memcpy(to(y) + rect.x0, from(y) + rect.x0, bytes);
}

/// Of its codes or, where there is some, of its light.
inline void copy_picture(const Canvas& from, const Canvas& to, const PixelRect& rect) {
    if (!to.light) return copy(from.color, to.color, rect);
    copy(from.light.red, to.light.red, rect);
    copy(from.light.green, to.light.green, rect);
    copy(from.light.blue, to.light.blue, rect);
}

template <typename T>
void fill(Rows<T> rows, const PixelRect& rect, T value) {
    for (int y = rect.y0; y < rect.y1; ++y) std::fill_n(rows(y) + rect.x0, std::max(0, rect.width()), value);
}

}  // namespace camrig::render::software
