#include "core/world/gltf/image_decode.h"

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <string>
#include <utility>

#include <turbojpeg.h>

#include "core/world/png_reader.h"

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

template <typename T>
T must(Result<T> made, std::string_view place) {
    if (!made) fail(place, made.error().message, made.error().kind);
    if constexpr (!std::is_void_v<T>) return std::move(*made);
}

/// Whose size has been checked.
PngReader open_png(std::span<const std::byte> bytes, std::string_view place) {
    PngReader png = must(PngReader::open(bytes), place);
    check_size(png.width(), png.height(), place);
    require(png.row_bytes() * png.height() <= max_deflate_ratio * bytes.size() + ratio_slack_bytes, place,
            "PNG: the data ends too early");
    return png;
}
ImageSize size_of(const PngReader& png) {
    return {static_cast<int>(png.width()), static_cast<int>(png.height())};
}

Image decode_png(std::span<const std::byte> bytes, std::string_view place, Budget& budget) {
    PngReader png = open_png(bytes, place);
    Image image;
    image.size = size_of(png);
    const auto size = static_cast<std::uint64_t>(image.size.pixels()) * 4;
    budget.take(size, place);
    image.rgba.resize(size);
    must(png.read_rgba(image.rgba.data()), place);
    return image;
}

bool is_png(std::span<const std::byte> bytes) {
    constexpr std::array<std::byte, 4> begin{std::byte{0x89}, std::byte{'P'}, std::byte{'N'}, std::byte{'G'}};
    return bytes.size() >= begin.size() && std::ranges::equal(bytes.first(begin.size()), begin);
}

bool is_jpeg(std::span<const std::byte> bytes) {
    const auto at = [&](std::size_t i) { return i < bytes.size() ? std::to_integer<int>(bytes[i]) : -1; };
    return at(0) == 0xFF && at(1) == 0xD8 && at(2) == 0xFF;
}

/// Its head has been read and its size checked.
struct OpenJpeg {
    std::unique_ptr<void, int (*)(tjhandle)> jpeg{tjInitDecompress(), tjDestroy};
    const unsigned char* data;
    ImageSize size;

    OpenJpeg(std::span<const std::byte> bytes, std::string_view place)
        : data(reinterpret_cast<const unsigned char*>(bytes.data())) {
        if (!jpeg) fail(place, "libjpeg-turbo has no memory", ErrorKind::resource_exhausted);
        int width = 0, height = 0, subsampling = 0, colorspace = 0;
        if (tjDecompressHeader3(jpeg.get(), data, bytes.size(), &width, &height, &subsampling, &colorspace) != 0)
            fail(place, std::string("JPEG: ") + tjGetErrorStr2(jpeg.get()));
        require(width > 0 && height > 0, place, "the picture is empty");
        check_size(static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height), place);
        size = {width, height};
        require(static_cast<std::uint64_t>(size.pixels()) * 4 <= max_jpeg_ratio * bytes.size() + ratio_slack_bytes,
                place, "JPEG: the data ends too early");
    }
};

Image decode_jpeg(std::span<const std::byte> bytes, std::string_view place, Budget& budget) {
    const OpenJpeg open(bytes, place);
    const auto [width, height] = open.size;
    const std::size_t size = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4;
    budget.take(size, place);
    Image image;
    image.size = open.size;
    image.rgba.resize(size);
    if (tjDecompress2(open.jpeg.get(), open.data, bytes.size(), image.rgba.data(), width, width * 4, height, TJPF_RGBA,
                      TJFLAG_ACCURATEDCT | TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS) != 0)
        fail(place, std::string("JPEG: ") + tjGetErrorStr2(open.jpeg.get()));
    return image;
}

}  // namespace

Image decode_image(std::span<const std::byte> bytes, std::string_view place, Budget& budget) {
    if (is_png(bytes)) return decode_png(bytes, place, budget);
    if (is_jpeg(bytes)) return decode_jpeg(bytes, place, budget);
    fail(place, "is neither a PNG nor a JPEG picture", ErrorKind::unsupported);
}

ImageSize image_size(std::span<const std::byte> bytes, std::string_view place) {
    if (is_png(bytes)) return size_of(open_png(bytes, place));
    if (is_jpeg(bytes)) return OpenJpeg(bytes, place).size;
    fail(place, "is neither a PNG nor a JPEG picture", ErrorKind::unsupported);
}

Gray16 decode_gray16(std::span<const std::byte> bytes, std::string_view place, Budget& budget) {
    if (!is_png(bytes)) fail(place, "is no PNG", ErrorKind::unsupported);
    PngReader png = open_png(bytes, place);
    require(png.is_gray() && png.bit_depth() == 16, place, "has to be gray, of 16 bits");
    Gray16 image;
    image.size = size_of(png);
    const auto count = static_cast<std::uint64_t>(image.size.pixels());
    budget.take(count * 2, place);
    image.values.resize(count);
    must(png.read_stored(reinterpret_cast<std::uint8_t*>(image.values.data())), place);
    if constexpr (std::endian::native == std::endian::little)
        for (std::uint16_t& value : image.values) value = std::byteswap(value);
    return image;
}

}  // namespace camrig::world::gltf
