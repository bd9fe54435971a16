#include <cstring>
#include <limits>

#include <gtest/gtest.h>
#include <png.h>

#include "core/codec/encoder.h"
#include "tests/unit/frame/test_pictures.h"

namespace camrig::codec {
namespace {

/// Decodes with libpng's simplified reader; 16-bit pictures are taken apart by decode_gray16.
std::vector<std::byte> decode(const std::vector<std::byte>& bytes, png_uint_32 format, ImageSize size) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    EXPECT_NE(png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()), 0) << image.message;
    EXPECT_EQ(image.width, static_cast<png_uint_32>(size.width));
    EXPECT_EQ(image.height, static_cast<png_uint_32>(size.height));
    image.format = format;
    std::vector<std::byte> pixels(PNG_IMAGE_SIZE(image));
    EXPECT_NE(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr), 0) << image.message;
    return pixels;
}

struct Source {
    const std::vector<std::byte>* bytes;
    std::size_t at = 0;
};

/// Opens for reading, through libpng's full interface, what `use` then looks at.
template <typename Use>
void read_with_libpng(const std::vector<std::byte>& bytes, Use use) {
    Source source{&bytes};
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_set_read_fn(png, &source, [](png_structp reader, png_bytep out, png_size_t length) {
        auto& from = *static_cast<Source*>(png_get_io_ptr(reader));
        std::memcpy(out, from.bytes->data() + from.at, length);
        from.at += length;
    });
    png_read_info(png, info);
    use(png, info);
    png_destroy_read_struct(&png, &info, nullptr);
}

std::vector<std::uint16_t> decode_gray16(const std::vector<std::byte>& bytes, ImageSize size) {
    std::vector<std::uint16_t> pixels(static_cast<std::size_t>(size.pixels()));
    read_with_libpng(bytes, [&](png_structp png, png_infop info) {
        EXPECT_EQ(png_get_bit_depth(png, info), 16);
        EXPECT_EQ(png_get_color_type(png, info), PNG_COLOR_TYPE_GRAY);
        png_set_swap(png);
        for (int y = 0; y < size.height; ++y) {
            png_read_row(png, reinterpret_cast<png_bytep>(pixels.data() + static_cast<std::ptrdiff_t>(y) * size.width),
                         nullptr);
        }
    });
    return pixels;
}

bool says_srgb(const std::vector<std::byte>& bytes) {
    bool says = false;
    read_with_libpng(bytes, [&](png_structp png, png_infop info) {
        int intent = -1;
        says = png_get_sRGB(png, info, &intent) != 0 && intent == PNG_sRGB_INTENT_PERCEPTUAL;
    });
    return says;
}

template <typename T>
frame::Frame frame_of(frame::PixelFormat format, ImageSize size, const std::vector<T>& values) {
    std::vector<std::byte> bytes(bytes_of(format, size));
    std::memcpy(bytes.data(), values.data(), bytes.size());
    return frame::Frame(frame::test::frame_info(size, format), std::move(bytes));
}

TEST(PngEncoder, ColourComesBackExactlyAtEverySizeAndLevel) {
    for (const int level : {0, 1, 6}) {
        auto encoder = create_png_encoder(level).value();
        for (const ImageSize size : {ImageSize{16, 16}, {17, 33}, {1, 1}, {641, 479}, {8192, 16}}) {
            const frame::Frame picture = frame::test::noise(size);
            const auto rgb = decode(*encoder->encode(picture).value(), PNG_FORMAT_RGB, size);
            for (std::size_t i = 0; i < rgb.size(); ++i) {
                ASSERT_EQ(rgb[i], picture.bytes()[i / 3 * 4 + i % 3]) << size.to_string() << " level " << level;
            }
        }
    }
}

TEST(PngEncoder, LargePicturesAreSound) {
    auto encoder = create_png_encoder().value();
    const frame::Frame picture = frame::test::smooth({4096, 2160});
    const auto rgba = decode(*encoder->encode(picture).value(), PNG_FORMAT_RGBA, {4096, 2160});
    EXPECT_TRUE(std::equal(rgba.begin(), rgba.end(), picture.bytes().begin(), picture.bytes().end()));
}

TEST(PngEncoder, PackedFormatsAndGrayComeBackExactly) {
    auto encoder = create_png_encoder().value();
    const std::pair<frame::PixelFormat, png_uint_32> cases[] = {{frame::PixelFormat::rgb24, PNG_FORMAT_RGB},
                                                                {frame::PixelFormat::bgr24, PNG_FORMAT_BGR},
                                                                {frame::PixelFormat::gray8, PNG_FORMAT_GRAY}};
    for (const auto& [format, png_format] : cases) {
        const frame::Frame picture = frame::test::noise({35, 21}, format);
        const auto pixels = decode(*encoder->encode(picture).value(), png_format, {35, 21});
        EXPECT_TRUE(std::equal(pixels.begin(), pixels.end(), picture.bytes().begin(), picture.bytes().end()))
            << to_string(format);
    }
}

TEST(PngEncoder, DepthIsMillimetresAndZeroWhereNothingIs) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    const std::vector<float> metres = {1.0F,
                                       0.0014F,
                                       0.0004F,
                                       65.535F,
                                       65.5354F,
                                       65.536F,
                                       1e9F,
                                       infinity,
                                       -1.0F,
                                       0.0F,
                                       std::numeric_limits<float>::quiet_NaN(),
                                       12.3456F};
    auto encoder = create_png_encoder().value();
    const auto mm =
        decode_gray16(*encoder->encode(frame_of(frame::PixelFormat::depth32f, {4, 3}, metres)).value(), {4, 3});
    EXPECT_EQ(mm, (std::vector<std::uint16_t>{1000, 1, 0, 65535, 65535, 0, 0, 0, 0, 0, 0, 12346}));
}

TEST(PngEncoder, IdsComeBackExactlyAndAreNeverCut) {
    auto encoder = create_png_encoder().value();
    const std::vector<std::uint32_t> ids = {0, 1, 256, 65535};
    EXPECT_EQ(decode_gray16(*encoder->encode(frame_of(frame::PixelFormat::id32, {4, 1}, ids)).value(), {4, 1}),
              (std::vector<std::uint16_t>{0, 1, 256, 65535}));
    const auto refused = encoder->encode(frame_of(frame::PixelFormat::id32, {1, 1}, std::vector<std::uint32_t>{65536}));
    EXPECT_EQ(refused.error().kind, ErrorKind::unsupported);
    EXPECT_NE(refused.error().message.find("65536"), std::string::npos);
}

TEST(PngEncoder, PicturesToLookAtAreSrgbAndNumbersAreNot) {
    auto encoder = create_png_encoder().value();
    EXPECT_TRUE(says_srgb(*encoder->encode(frame::test::smooth({16, 16})).value()));
    const auto ids = frame_of(frame::PixelFormat::id32, {2, 1}, std::vector<std::uint32_t>{1, 2});
    EXPECT_FALSE(says_srgb(*encoder->encode(ids).value()));
}

TEST(PngEncoder, HigherLevelsAreSmallerAndZeroStores) {
    const frame::Frame picture = frame::test::smooth({320, 240});
    const auto bytes_at = [&](int level) { return create_png_encoder(level).value()->encode(picture).value()->size(); };
    EXPECT_GE(bytes_at(0), 320U * 240U * 3U);
    EXPECT_LT(bytes_at(1), bytes_at(0) / 4);
    EXPECT_LE(bytes_at(9), bytes_at(1));
}

TEST(PngEncoder, BadInputIsAnError) {
    EXPECT_EQ(create_png_encoder(-1).error().kind, ErrorKind::invalid_argument);
    EXPECT_EQ(create_png_encoder(10).error().kind, ErrorKind::invalid_argument);
    auto encoder = create_png_encoder().value();
    EXPECT_EQ(encoder->encode(frame::test::noise({16, 16}, frame::PixelFormat::yuyv)).error().kind,
              ErrorKind::unsupported);
    EXPECT_EQ(encoder->encode(frame::Frame(frame::test::frame_info({0, 0}), std::vector<std::byte>{})).error().kind,
              ErrorKind::invalid_argument);
    EXPECT_TRUE(encoder->encode(frame::test::noise({16, 16})).has_value()) << "and it goes on";
}

}  // namespace
}  // namespace camrig::codec
