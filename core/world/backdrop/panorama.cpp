#include "core/world/backdrop/panorama.h"

#include <bit>
#include <string>

namespace camrig::world {
namespace {

constexpr int max_scale = 64;

/// A rectangle of a panorama goes on at the left where it leaves it on the right: the one or two parts of it, and which
/// of its columns each begins with.
struct Part {
    PixelRect rect;
    int first = 0;
};
std::vector<Part> parts_of(const PixelRect& rect, int columns) {
    std::vector<Part> parts{{{rect.x0, rect.y0, std::min(rect.x1, columns), rect.y1}, 0}};
    if (rect.x1 > columns) parts.push_back({{0, rect.y0, rect.x1 - columns, rect.y1}, columns - rect.x0});
    return parts;
}

PixelRect rect_of(const PanoramaDetail& detail, ImageSize size) {
    return {detail.at_px.x, detail.at_px.y, detail.at_px.x + size.width, detail.at_px.y + size.height};
}

PixelRect half_of(const PixelRect& rect) {
    return {rect.x0 / 2, rect.y0 / 2, (rect.x1 + 1) / 2, (rect.y1 + 1) / 2};
}

std::string megabytes(std::size_t bytes) {
    return std::to_string(bytes >> 20) + " MiB";
}

}  // namespace

Result<PanoramaMaker> PanoramaMaker::create(Image whole, int finest) {
    constexpr int least_width = 16;
    const auto [width, height] = whole.size;
    if (width != 2 * height || width < least_width)
        return error(ErrorKind::invalid_argument,
                     "a panorama of " + whole.size.to_string() +
                         "; it shows the whole sphere, and is twice as wide as high (16x8 pixels or more)");
    PanoramaMaker maker(make_pyramid(std::move(whole)));
    for (int scale = finest; scale > 1; scale /= 2)
        maker.made_->finer.emplace_back(ImageSize{width * scale, height * scale});
    return maker;
}

std::string PanoramaMaker::scale_problem(int scale, int columns) {
    if (scale < 2 || scale > max_scale || !std::has_single_bit(static_cast<unsigned>(scale)))
        return "must be 2, 4, 8, 16, 32 or 64";
    if (columns > max_columns / scale)
        return "times the " + std::to_string(columns) + " columns of the panorama this is over " +
               std::to_string(max_columns);
    return {};
}

SparsePicture& PanoramaMaker::level_of(int scale) {
    return made_->finer[made_->finer.size() - static_cast<std::size_t>(std::countr_zero(static_cast<unsigned>(scale)))];
}

Result<void> PanoramaMaker::reserve(const PanoramaDetail& detail, ImageSize size, std::size_t most_bytes) {
    const auto [columns, rows] = level_of(detail.scale).size();
    const PixelRect rect = rect_of(detail, size);
    if (rect.x0 >= columns || size.width > columns || rect.y1 > rows)
        return error(ErrorKind::invalid_argument, "at_px: a picture of " + size.to_string() + " at " +
                                                      std::to_string(rect.x0) + ", " + std::to_string(rect.y0) +
                                                      " is beyond the " + std::to_string(columns) + "x" +
                                                      std::to_string(rows) + " pixels of the panorama at this scale");
    // Beside it, all that is made of it for views that see it smaller.
    const auto each_level = [&](const auto& fn) {
        for (const Part& part : parts_of(rect, columns)) {
            PixelRect here = part.rect;
            for (int scale = detail.scale; scale > 1; scale /= 2, here = half_of(here)) fn(level_of(scale), here);
        }
    };
    std::size_t bytes = 0;
    each_level([&](const SparsePicture& level, const PixelRect& here) { bytes += level.bytes_of(here); });
    if (bytes_ + bytes > most_bytes)
        return error(ErrorKind::resource_exhausted, "file: with it the panorama's details take over " +
                                                        megabytes(most_bytes) + " of memory (" + megabytes(bytes_) +
                                                        " without it); leave some out, or give them a smaller scale");
    bytes_ += bytes;
    each_level([](SparsePicture& level, const PixelRect& here) { level.reserve(here); });
    return {};
}

void PanoramaMaker::put(const PanoramaDetail& detail, const Image& picture) {
    SparsePicture& level = level_of(detail.scale);
    for (const Part& part : parts_of(rect_of(detail, picture.size), level.size().width))
        level.put(picture, part.first, part.rect);
}

std::shared_ptr<const Panorama> PanoramaMaker::finish() {
    for (std::size_t i = 1; i < made_->finer.size(); ++i) made_->finer[i].fill_from(made_->finer[i - 1]);
    return std::move(made_);
}

}  // namespace camrig::world
