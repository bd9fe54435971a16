#include "core/frame/convert.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <vector>

#include <libyuv.h>

#include "core/frame/rgb_to_yuv.h"

namespace camrig::frame {
namespace {

std::uint8_t* as_u8(std::byte* bytes) {
    return reinterpret_cast<std::uint8_t*>(bytes);
}
const std::uint8_t* as_u8(const std::byte* bytes) {
    return reinterpret_cast<const std::uint8_t*>(bytes);
}

bool is_color(PixelFormat format) {
    return std::ranges::find(color_formats, format) != color_formats.end();
}

Result<void> check(const FrameInfo& info, PixelFormat format, ImageSize size) {
    if (info.format != PixelFormat::rgba8 || !is_color(format)) {
        return error(ErrorKind::unsupported, "no conversion from " + std::string(to_string(info.format)) + " to " +
                                                 std::string(to_string(format)) +
                                                 "; only rgba8 becomes another format, and only a colour format");
    }
    if (size.width < 1 || size.height < 1 || size > max_image_size || size.height > max_image_size.height) {
        return error(ErrorKind::invalid_argument, "cannot scale a frame to " + size.to_string() +
                                                      "; sizes go from 1x1 to " + max_image_size.to_string());
    }
    return {};
}

/// The rows of an rgba8 picture; the row after the last is the last again.
struct Rows {
    const std::byte* pixels;
    ImageSize size;
    const std::byte* operator[](int y) const {
        if (y >= size.height) y = size.height - 1;
        return pixels + static_cast<std::ptrdiff_t>(y) * size.width * 4;
    }
};

/// Rows first <= y < end of a picture; first is even, and so is end unless it is the picture's height.
struct Range {
    int first, end;
};

/// One row of Y, U and V on the stack, between planes and packed formats.
constexpr std::size_t max_row = std::size_t{2} * max_image_size.width;

void write_luma(YuvRange codes, Rows rows, Range range, std::byte* out) {
    for (int y = range.first; y < range.end; ++y) {
        luma_row(codes, rows[y], rows.size.width, out + static_cast<std::ptrdiff_t>(y) * rows.size.width);
    }
}

void write_planar(YuvRange codes, Rows rows, Range range, std::byte* out) {
    const std::ptrdiff_t half_width = (rows.size.width + 1) / 2;
    const int half_height = (rows.size.height + 1) / 2;
    std::byte* const u = out + rows.size.pixels();
    std::byte* const v = u + half_width * half_height;
    write_luma(codes, rows, range, out);
    for (int y = range.first / 2; y < (range.end + 1) / 2; ++y) {
        chroma_row(codes, rows[2 * y], rows[2 * y + 1], rows.size.width, u + y * half_width, v + y * half_width);
    }
}

void write_nv12(Rows rows, Range range, std::byte* out) {
    const int half_width = (rows.size.width + 1) / 2;
    std::array<std::byte, max_row> row;
    std::byte* const u = row.data();
    std::byte* const v = u + half_width;
    write_luma(YuvRange::limited, rows, range, out);
    out += rows.size.pixels();
    for (int y = range.first / 2; y < (range.end + 1) / 2; ++y) {
        chroma_row(YuvRange::limited, rows[2 * y], rows[2 * y + 1], rows.size.width, u, v);
        libyuv::MergeUVPlane(as_u8(u), half_width, as_u8(v), half_width,
                             as_u8(out + static_cast<std::ptrdiff_t>(y) * 2 * half_width), 2 * half_width, half_width,
                             1);
    }
}

void write_yuyv(Rows rows, Range range, std::byte* out) {
    const int half_width = (rows.size.width + 1) / 2;
    std::array<std::byte, max_row> row;
    std::byte* const luma = row.data();
    std::byte* const u = luma + 2 * half_width;
    std::byte* const v = u + half_width;
    for (int y = range.first; y < range.end; ++y) {
        luma_row(YuvRange::limited, rows[y], rows.size.width, luma);
        if (rows.size.width % 2 == 1) luma[rows.size.width] = luma[rows.size.width - 1];
        chroma_row(YuvRange::limited, rows[y], rows[y], rows.size.width, u, v);
        libyuv::I422ToYUY2(as_u8(luma), 2 * half_width, as_u8(u), half_width, as_u8(v), half_width,
                           as_u8(out + static_cast<std::ptrdiff_t>(y) * 4 * half_width), 4 * half_width, 2 * half_width,
                           1);
    }
}

/// libyuv names pixels as little-endian numbers: our R G B A bytes are its ABGR. Its ARGBToX work on any byte order;
/// "RGB24" keeps the order of the first three bytes and "RAW" reverses it.
void write_rows(Rows rows, Range range, PixelFormat format, std::byte* out) {
    const int width = rows.size.width, count = range.end - range.first;
    const std::byte* const in = rows[range.first];
    std::byte* const out_24 = out + static_cast<std::ptrdiff_t>(range.first) * 3 * width;
    switch (format) {
        case PixelFormat::rgba8:
            std::memcpy(out + (in - rows.pixels), in, bytes_of(format, {width, count}));
            return;
        case PixelFormat::rgb24:
            libyuv::ARGBToRGB24(as_u8(in), 4 * width, as_u8(out_24), 3 * width, width, count);
            return;
        case PixelFormat::bgr24:
            libyuv::ARGBToRAW(as_u8(in), 4 * width, as_u8(out_24), 3 * width, width, count);
            return;
        case PixelFormat::yuyv:
            write_yuyv(rows, range, out);
            return;
        case PixelFormat::i420:
            write_planar(YuvRange::limited, rows, range, out);
            return;
        case PixelFormat::nv12:
            write_nv12(rows, range, out);
            return;
        case PixelFormat::jpeg_i420:
            write_planar(YuvRange::full, rows, range, out);
            return;
        case PixelFormat::gray8:
            write_luma(YuvRange::full, rows, range, out);
            return;
        case PixelFormat::depth32f:
        case PixelFormat::id32:
        case PixelFormat::normal32f:
        case PixelFormat::flow32f:
        case PixelFormat::gray16:
        case PixelFormat::bayer_rggb16:
        case PixelFormat::bayer_grbg16:
        case PixelFormat::bayer_gbrg16:
        case PixelFormat::bayer_bggr16:
        case PixelFormat::rgb16_planes:
            break;
    }
    CHECK(!"a colour format");
}

void write_same_size(Rows rows, PixelFormat format, std::byte* out) {
    write_rows(rows, {0, rows.size.height}, format, out);
}

/// Copies rows between two pictures of this format: of planes with a row for each two, those of the range.
void copy_rows(PixelFormat format, ImageSize size, Range range, const std::byte* from, std::byte* to) {
    const bool has_half_planes =
        format == PixelFormat::i420 || format == PixelFormat::jpeg_i420 || format == PixelFormat::nv12;
    const auto row_bytes =
        static_cast<std::ptrdiff_t>(has_half_planes ? size.width : bytes_of(format, {size.width, 1}));
    const auto copy = [&](std::ptrdiff_t plane, std::ptrdiff_t bytes, int first, int end) {
        std::memcpy(to + plane + first * bytes, from + plane + first * bytes,
                    static_cast<std::size_t>((end - first) * bytes));
    };
    copy(0, row_bytes, range.first, range.end);
    if (!has_half_planes) return;
    const std::ptrdiff_t half_width = (size.width + 1) / 2, half_height = (size.height + 1) / 2;
    const int first = range.first / 2, end = (range.end + 1) / 2;
    if (format == PixelFormat::nv12) return copy(size.pixels(), 2 * half_width, first, end);
    copy(size.pixels(), half_width, first, end);
    copy(size.pixels() + half_width * half_height, half_width, first, end);
}

/// What write_same_size() gives, when `last` is what it gave of the frame since which this one's damage is told.
void write_damaged(const Frame& frame, const Frame& last, Frame& out) {
    const auto [width, height] = frame.info().size;
    const Damage& damage = frame.info().damage;
    const PixelFormat format = out.info().format;
    constexpr int band_rows = Damage::band_rows;
    for (int band = 0, end = 0; band * band_rows < height; band = end) {
        const bool is_new = damage.contains_band(band);
        end = band + 1;
        while (end * band_rows < height && damage.contains_band(end) == is_new) ++end;
        const Range range{band * band_rows, std::min(end * band_rows, height)};
        std::byte* const bytes = out.mutable_bytes().data();
        is_new ? write_rows({frame.bytes().data(), {width, height}}, range, format, bytes)
               : copy_rows(format, {width, height}, range, last.bytes().data(), bytes);
    }
}

void scale_rgba(Rows from, ImageSize size, std::byte* out) {
    const int failed = libyuv::ARGBScale(as_u8(from.pixels), 4 * from.size.width, from.size.width, from.size.height,
                                         as_u8(out), 4 * size.width, size.width, size.height, libyuv::kFilterBox);
    CHECK(failed == 0);
}

}  // namespace

Result<void> convert(const Frame& rgba, PixelFormat format, ImageSize size, std::span<std::byte> out) {
    const FrameInfo& info = rgba.info();
    if (size == ImageSize{}) size = info.size;
    if (auto good = check(info, format, size); !good) return good;
    CHECK(out.size() == bytes_of(format, size));

    const Rows rows{rgba.bytes().data(), info.size};
    if (size == info.size) {
        write_same_size(rows, format, out.data());
    } else if (format == PixelFormat::rgba8) {
        scale_rgba(rows, size, out.data());
    } else {
        std::vector<std::byte> scaled(bytes_of(PixelFormat::rgba8, size));
        scale_rgba(rows, size, scaled.data());
        write_same_size({scaled.data(), size}, format, out.data());
    }
    return {};
}

Result<FrameRef> converted(FramePool& pool, const FrameRef& frame, PixelFormat format, ImageSize size,
                           const FrameRef& last) {
    const FrameInfo& info = frame->info();
    if (size == ImageSize{}) size = info.size;
    if (format == info.format && size == info.size) return frame;
    if (auto good = check(info, format, size); !good) return std::unexpected(good.error());

    FrameRef source = frame;
    if (size != info.size) {
        FrameInfo scaled_info = info;
        scaled_info.size = size;
        // Damaged rows are those of the frame, and a scaled row is made of several.
        scaled_info.damage = {};
        std::shared_ptr<Frame> scaled = pool.acquire(std::move(scaled_info));
        scale_rgba({frame->bytes().data(), info.size}, size, scaled->mutable_bytes().data());
        if (format == PixelFormat::rgba8) return scaled;
        source = std::move(scaled);
    }
    // Every layout makes a row, and a pair of rows from an even one on, of these alone: the same bands are damaged.
    FrameInfo target_info = source->info();
    target_info.format = format;
    std::shared_ptr<Frame> target = pool.acquire(std::move(target_info));
    if (last && last->info().format == format && is_damage_since(last->info(), source->info())) {
        write_damaged(*source, *last, *target);
    } else {
        write_same_size({source->bytes().data(), size}, format, target->mutable_bytes().data());
    }
    return target;
}

}  // namespace camrig::frame
