#include "core/frame/convert.h"

#include <array>
#include <cstring>
#include <string>
#include <vector>

#include <libyuv.h>

#include "core/frame/rgb_to_yuv.h"

namespace camrig {
namespace {

std::uint8_t* as_u8(std::byte* bytes) {
    return reinterpret_cast<std::uint8_t*>(bytes);
}
const std::uint8_t* as_u8(const std::byte* bytes) {
    return reinterpret_cast<const std::uint8_t*>(bytes);
}

bool is_color(PixelFormat format) {
    return format != PixelFormat::depth32f && format != PixelFormat::id32 && format != PixelFormat::normal32f;
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

/// One row of Y, U and V on the stack, between planes and packed formats.
constexpr std::size_t max_row = std::size_t{2} * max_image_size.width;

void write_luma(YuvRange range, Rows rows, std::byte* out) {
    for (int y = 0; y < rows.size.height; ++y) {
        luma_row(range, rows[y], rows.size.width, out + static_cast<std::ptrdiff_t>(y) * rows.size.width);
    }
}

void write_planar(YuvRange range, Rows rows, std::byte* out) {
    const int half_width = (rows.size.width + 1) / 2;
    const int half_height = (rows.size.height + 1) / 2;
    std::byte* u = out + rows.size.pixels();
    std::byte* v = u + static_cast<std::ptrdiff_t>(half_width) * half_height;
    write_luma(range, rows, out);
    for (int y = 0; y < half_height; ++y, u += half_width, v += half_width) {
        chroma_row(range, rows[2 * y], rows[2 * y + 1], rows.size.width, u, v);
    }
}

void write_nv12(Rows rows, std::byte* out) {
    const int half_width = (rows.size.width + 1) / 2;
    std::array<std::byte, max_row> row;
    std::byte* const u = row.data();
    std::byte* const v = u + half_width;
    write_luma(YuvRange::limited, rows, out);
    out += rows.size.pixels();
    for (int y = 0; y < (rows.size.height + 1) / 2; ++y, out += 2 * half_width) {
        chroma_row(YuvRange::limited, rows[2 * y], rows[2 * y + 1], rows.size.width, u, v);
        libyuv::MergeUVPlane(as_u8(u), half_width, as_u8(v), half_width, as_u8(out), 2 * half_width, half_width, 1);
    }
}

void write_yuyv(Rows rows, std::byte* out) {
    const int half_width = (rows.size.width + 1) / 2;
    std::array<std::byte, max_row> row;
    std::byte* const luma = row.data();
    std::byte* const u = luma + 2 * half_width;
    std::byte* const v = u + half_width;
    for (int y = 0; y < rows.size.height; ++y, out += 4 * half_width) {
        luma_row(YuvRange::limited, rows[y], rows.size.width, luma);
        if (rows.size.width % 2 == 1) luma[rows.size.width] = luma[rows.size.width - 1];
        chroma_row(YuvRange::limited, rows[y], rows[y], rows.size.width, u, v);
        libyuv::I422ToYUY2(as_u8(luma), 2 * half_width, as_u8(u), half_width, as_u8(v), half_width, as_u8(out),
                           4 * half_width, 2 * half_width, 1);
    }
}

/// libyuv names pixels as little-endian numbers: our R G B A bytes are its ABGR. Its ARGBToX work on any byte order;
/// "RGB24" keeps the order of the first three bytes and "RAW" reverses it.
void write_same_size(Rows rows, PixelFormat format, std::byte* out) {
    const auto [width, height] = rows.size;
    const std::uint8_t* const in = as_u8(rows.pixels);
    switch (format) {
        case PixelFormat::rgba8:
            std::memcpy(out, rows.pixels, bytes_of(format, rows.size));
            return;
        case PixelFormat::rgb24:
            libyuv::ARGBToRGB24(in, 4 * width, as_u8(out), 3 * width, width, height);
            return;
        case PixelFormat::bgr24:
            libyuv::ARGBToRAW(in, 4 * width, as_u8(out), 3 * width, width, height);
            return;
        case PixelFormat::yuyv:
            write_yuyv(rows, out);
            return;
        case PixelFormat::i420:
            write_planar(YuvRange::limited, rows, out);
            return;
        case PixelFormat::nv12:
            write_nv12(rows, out);
            return;
        case PixelFormat::jpeg_i420:
            write_planar(YuvRange::full, rows, out);
            return;
        case PixelFormat::gray8:
            write_luma(YuvRange::full, rows, out);
            return;
        case PixelFormat::depth32f:
        case PixelFormat::id32:
        case PixelFormat::normal32f:
            break;
    }
    CHECK(!"a colour format");
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

Result<FrameRef> converted(FramePool& pool, const FrameRef& frame, PixelFormat format, ImageSize size) {
    const FrameInfo& info = frame->info();
    if (size == ImageSize{}) size = info.size;
    if (format == info.format && size == info.size) return frame;
    if (auto good = check(info, format, size); !good) return std::unexpected(good.error());

    FrameRef source = frame;
    if (size != info.size) {
        FrameInfo scaled_info = info;
        scaled_info.size = size;
        // Changed rows are those of the frame, and a scaled row is made of several.
        scaled_info.same_as = -1;
        scaled_info.changed_rows.clear();
        std::shared_ptr<Frame> scaled = pool.acquire(std::move(scaled_info));
        scale_rgba({frame->bytes().data(), info.size}, size, scaled->mutable_bytes().data());
        if (format == PixelFormat::rgba8) return scaled;
        source = std::move(scaled);
    }
    // Every layout makes a row, and a pair of rows from an even one on, of these alone: what changed, changed.
    FrameInfo target_info = source->info();
    target_info.format = format;
    std::shared_ptr<Frame> target = pool.acquire(std::move(target_info));
    write_same_size({source->bytes().data(), size}, format, target->mutable_bytes().data());
    return target;
}

}  // namespace camrig
