#include "core/world/gltf/image_decode.h"

#include <algorithm>
#include <array>
#include <bit>
#include <csetjmp>
#include <cstring>
#include <memory>
#include <string>

#include <png.h>
#include <turbojpeg.h>

namespace camrig::world::gltf {
namespace {

// Deflate cannot make more than 1032 bytes of one; a JPEG block takes at least a bit or two. What claims more is cut
// short or hostile, and gets no memory.
constexpr std::uint64_t max_deflate_ratio = 1032;
constexpr std::uint64_t max_jpeg_ratio = 2000;
constexpr std::uint64_t ratio_slack_bytes = 4096;

void check_size(std::uint64_t width, std::uint64_t height, std::string_view place) {
    require(width > 0 && height > 0, place, "the picture is empty");
    require(width <= max_image_side && height <= max_image_side, place,
            "a picture of " + std::to_string(width) + "x" + std::to_string(height) + "; at most 16384x16384 is read");
}

struct PngRead {
    std::span<const std::byte> bytes;
    std::size_t offset = 0;
    char message[160] = "";
    std::jmp_buf jump{};
};

void png_failed(png_structp png, png_const_charp message) {
    auto* read = static_cast<PngRead*>(png_get_error_ptr(png));
    std::strncpy(read->message, message, sizeof read->message - 1);
    std::longjmp(read->jump, 1);
}

void png_ignore(png_structp, png_const_charp) {}

void png_give(png_structp png, png_bytep out, std::size_t size) {
    auto* read = static_cast<PngRead*>(png_get_io_ptr(png));
    if (size > read->bytes.size() - read->offset) png_error(png, "the data ends too early");
    std::memcpy(out, read->bytes.data() + read->offset, size);
    read->offset += size;
}

// libpng leaves by longjmp, so the two halves below hold nothing that needs a destructor.
bool png_header(png_structp png, png_infop info, PngRead& read) {
    if (setjmp(read.jump)) return false;
    png_read_info(png, info);
    return true;
}

bool png_pixels(png_structp png, png_infop info, PngRead& read, bool as_gray16, std::uint8_t* out, std::size_t stride) {
    if (setjmp(read.jump)) return false;
    if (as_gray16) {
        // PNG's numbers have their high byte first.
        if constexpr (std::endian::native == std::endian::little) png_set_swap(png);
    } else {
        png_set_expand(png);
        png_set_scale_16(png);
        png_set_gray_to_rgb(png);
        png_set_add_alpha(png, 0xFF, PNG_FILLER_AFTER);
    }
    const int passes = png_set_interlace_handling(png);
    png_read_update_info(png, info);
    if (png_get_rowbytes(png, info) != stride) png_error(png, "unexpected row size");
    const png_uint_32 height = png_get_image_height(png, info);
    for (int pass = 0; pass < passes; ++pass)
        for (png_uint_32 y = 0; y < height; ++y) png_read_row(png, out + y * stride, nullptr);
    return true;
}

/// Rows of `pixel_bytes` a pixel: RGBA or, as_gray16, that of a picture which has to be so. place_for(size) takes the
/// memory.
template <typename PlaceFor>
void decode_png(std::span<const std::byte> bytes, std::string_view place, bool as_gray16, std::size_t pixel_bytes,
                PlaceFor place_for) {
    PngRead read{.bytes = bytes};
    struct Handle {
        png_structp png = nullptr;
        png_infop info = nullptr;
        ~Handle() { png_destroy_read_struct(&png, &info, nullptr); }
    } handle;
    handle.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &read, png_failed, png_ignore);
    if (handle.png) handle.info = png_create_info_struct(handle.png);
    if (!handle.info) fail(place, "libpng has no memory", ErrorKind::resource_exhausted);
    png_set_user_limits(handle.png, max_image_side, max_image_side);
    png_set_chunk_cache_max(handle.png, 128);
    png_set_chunk_malloc_max(handle.png, 8 << 20);
    png_set_read_fn(handle.png, &read, png_give);
    if (!png_header(handle.png, handle.info, read)) fail(place, std::string("PNG: ") + read.message);

    const std::uint64_t width = png_get_image_width(handle.png, handle.info);
    const std::uint64_t height = png_get_image_height(handle.png, handle.info);
    check_size(width, height, place);
    require(png_get_rowbytes(handle.png, handle.info) * height <= max_deflate_ratio * bytes.size() + ratio_slack_bytes,
            place, "PNG: the data ends too early");
    if (as_gray16)
        require(png_get_color_type(handle.png, handle.info) == PNG_COLOR_TYPE_GRAY &&
                    png_get_bit_depth(handle.png, handle.info) == 16,
                place, "has to be gray, of 16 bits");
    std::uint8_t* const out = place_for(ImageSize{static_cast<int>(width), static_cast<int>(height)});
    if (!png_pixels(handle.png, handle.info, read, as_gray16, out, width * pixel_bytes))
        fail(place, std::string("PNG: ") + read.message);
}

bool is_png(std::span<const std::byte> bytes) {
    constexpr std::array<std::byte, 4> begin{std::byte{0x89}, std::byte{'P'}, std::byte{'N'}, std::byte{'G'}};
    return bytes.size() >= begin.size() && std::ranges::equal(bytes.first(begin.size()), begin);
}

Image decode_jpeg(std::span<const std::byte> bytes, std::string_view place, Budget& budget) {
    const std::unique_ptr<void, int (*)(tjhandle)> jpeg(tjInitDecompress(), tjDestroy);
    if (!jpeg) fail(place, "libjpeg-turbo has no memory", ErrorKind::resource_exhausted);
    const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
    int width = 0, height = 0, subsampling = 0, colorspace = 0;
    if (tjDecompressHeader3(jpeg.get(), data, bytes.size(), &width, &height, &subsampling, &colorspace) != 0)
        fail(place, std::string("JPEG: ") + tjGetErrorStr2(jpeg.get()));
    require(width > 0 && height > 0, place, "the picture is empty");
    check_size(static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height), place);
    const std::size_t size = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4;
    require(size <= max_jpeg_ratio * bytes.size() + ratio_slack_bytes, place, "JPEG: the data ends too early");
    budget.take(size, place);
    Image image;
    image.size = {width, height};
    image.rgba.resize(size);
    if (tjDecompress2(jpeg.get(), data, bytes.size(), image.rgba.data(), width, width * 4, height, TJPF_RGBA,
                      TJFLAG_ACCURATEDCT | TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS) != 0)
        fail(place, std::string("JPEG: ") + tjGetErrorStr2(jpeg.get()));
    return image;
}

}  // namespace

Image decode_image(std::span<const std::byte> bytes, std::string_view place, Budget& budget) {
    if (is_png(bytes)) {
        Image image;
        decode_png(bytes, place, false, 4, [&](ImageSize size) {
            image.size = size;
            budget.take(static_cast<std::uint64_t>(size.pixels()) * 4, place);
            image.rgba.resize(static_cast<std::size_t>(size.pixels()) * 4);
            return image.rgba.data();
        });
        return image;
    }
    const auto at = [&](std::size_t i) { return i < bytes.size() ? std::to_integer<int>(bytes[i]) : -1; };
    if (at(0) == 0xFF && at(1) == 0xD8 && at(2) == 0xFF) return decode_jpeg(bytes, place, budget);
    fail(place, "is neither a PNG nor a JPEG picture", ErrorKind::unsupported);
}

Gray16 decode_gray16(std::span<const std::byte> bytes, std::string_view place, Budget& budget) {
    if (!is_png(bytes)) fail(place, "is no PNG", ErrorKind::unsupported);
    Gray16 image;
    decode_png(bytes, place, true, 2, [&](ImageSize size) {
        image.size = size;
        budget.take(static_cast<std::uint64_t>(size.pixels()) * 2, place);
        image.values.resize(static_cast<std::size_t>(size.pixels()));
        return reinterpret_cast<std::uint8_t*>(image.values.data());
    });
    return image;
}

}  // namespace camrig::world::gltf
