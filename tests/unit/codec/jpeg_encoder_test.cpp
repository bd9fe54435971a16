#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <turbojpeg.h>

#include "core/codec/encoder.h"
#include "core/frame/code_strip.h"
#include "core/frame/convert.h"
#include "tests/unit/frame/test_pictures.h"

namespace camrig::codec {
namespace {

using frame::test::code;

struct Decoded {
    ImageSize size;
    int subsampling = -1;
    std::vector<std::byte> rgba;
};

Decoded decode(const std::vector<std::byte>& jpeg) {
    Decoded decoded;
    tjhandle handle = tjInitDecompress();
    const auto* const bytes = reinterpret_cast<const unsigned char*>(jpeg.data());
    int colorspace = 0;
    EXPECT_EQ(tjDecompressHeader3(handle, bytes, jpeg.size(), &decoded.size.width, &decoded.size.height,
                                  &decoded.subsampling, &colorspace),
              0);
    decoded.rgba.resize(bytes_of(frame::PixelFormat::rgba8, decoded.size));
    EXPECT_EQ(tjDecompress2(handle, bytes, jpeg.size(), reinterpret_cast<unsigned char*>(decoded.rgba.data()),
                            decoded.size.width, 0, decoded.size.height, TJPF_RGBA, TJFLAG_ACCURATEDCT),
              0)
        << tjGetErrorStr2(handle);
    tjDestroy(handle);
    return decoded;
}

double psnr(std::span<const std::byte> a, std::span<const std::byte> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (i % 4 != 3) sum += std::pow(code(a[i]) - code(b[i]), 2);
    }
    return sum == 0 ? 100 : 10 * std::log10(255.0 * 255.0 / (sum / (static_cast<double>(a.size()) * 0.75)));
}

frame::Frame as_format(const frame::Frame& rgba, frame::PixelFormat format) {
    frame::FrameInfo info = rgba.info();
    info.format = format;
    std::vector<std::byte> bytes(bytes_of(format, info.size));
    EXPECT_TRUE(convert(rgba, format, {}, bytes).has_value());
    return frame::Frame(info, std::move(bytes));
}

/// What TurboJPEG makes of the same samples, with a restart marker after each strip of 16 rows, as ours have.
std::vector<std::byte> by_turbojpeg(const frame::Frame& picture, int quality, int subsampling) {
    const auto [width, height] = picture.info().size;
    const auto* samples = reinterpret_cast<const unsigned char*>(picture.bytes().data());
    ::setenv("TJ_RESTART", std::to_string(16 / tjMCUHeight[subsampling]).c_str(), 1);
    tjhandle handle = tjInitCompress();
    unsigned char* bytes = nullptr;
    unsigned long size = 0;
    if (picture.info().format == frame::PixelFormat::jpeg_i420) {
        // Its planes have an even number of rows and columns; the last ones are there twice.
        const int half = (width + 1) / 2, rows = (height + 1) / 2;
        std::vector<unsigned char> luma;
        for (int y = 0; y < 2 * rows; ++y)
            for (int x = 0; x < 2 * half; ++x)
                luma.push_back(samples[std::min(y, height - 1) * width + std::min(x, width - 1)]);
        const unsigned char* const u = samples + width * height;
        const unsigned char* planes[] = {luma.data(), u, u + half * rows};
        const int strides[] = {2 * half, half, half};
        EXPECT_EQ(tjCompressFromYUVPlanes(handle, planes, width, strides, height, subsampling, &bytes, &size, quality,
                                          TJFLAG_ACCURATEDCT),
                  0);
    } else {
        const int layout = picture.info().format == frame::PixelFormat::gray8 ? TJPF_GRAY : TJPF_RGBX;
        EXPECT_EQ(tjCompress2(handle, samples, width, 0, height, layout, &bytes, &size, subsampling, quality,
                              TJFLAG_ACCURATEDCT),
                  0);
    }
    const auto made = std::as_bytes(std::span(bytes, size));
    std::vector<std::byte> jpeg(made.begin(), made.end());
    tjFree(bytes);
    tjDestroy(handle);
    ::unsetenv("TJ_RESTART");
    return jpeg;
}

TEST(JpegEncoder, QualityBuysFidelity) {
    const frame::Frame picture = frame::test::smooth({640, 480});
    double last = 0;
    std::size_t last_bytes = 0;
    for (const auto& [quality, wanted] : {std::pair{20, 36.0}, {50, 40.0}, {75, 42.0}, {90, 44.0}, {98, 46.0}}) {
        auto encoder = create_jpeg_encoder(quality).value();
        const BytesRef jpeg = encoder->encode(picture).value();
        const double fidelity = psnr(decode(*jpeg).rgba, picture.bytes());
        EXPECT_GT(fidelity, wanted) << quality;
        EXPECT_GT(fidelity, last - 0.5) << quality;
        EXPECT_GT(jpeg->size(), last_bytes) << quality;
        last = fidelity;
        last_bytes = jpeg->size();
    }
}

TEST(JpegEncoder, EverySizeIsSoundFromPixelsAndFromPlanes) {
    auto encoder = create_jpeg_encoder(90).value();
    for (const ImageSize size : {ImageSize{16, 16},
                                 {17, 17},
                                 {16, 17},
                                 {17, 16},
                                 {1, 1},
                                 {99, 63},
                                 {641, 479},
                                 {8192, 16},
                                 {1920, 1080},
                                 {4096, 2160},
                                 {33, 4096}}) {
        const frame::Frame picture = frame::test::smooth(size);
        for (const frame::PixelFormat format : {frame::PixelFormat::rgba8, frame::PixelFormat::bgr24,
                                                frame::PixelFormat::rgb24, frame::PixelFormat::jpeg_i420}) {
            const auto jpeg =
                encoder->encode(format == frame::PixelFormat::rgba8 ? picture : as_format(picture, format));
            ASSERT_TRUE(jpeg.has_value()) << jpeg.error().message;
            const Decoded decoded = decode(**jpeg);
            ASSERT_EQ(decoded.size, size);
            EXPECT_EQ(decoded.subsampling, TJSAMP_420);
            EXPECT_GT(psnr(decoded.rgba, picture.bytes()), 30) << size.to_string() << " " << to_string(format);
        }
    }
}

TEST(JpegEncoder, PlanesGiveThePictureThatPixelsGive) {
    auto encoder = create_jpeg_encoder(95).value();
    for (const ImageSize size : {ImageSize{320, 240}, {321, 241}}) {
        const frame::Frame picture = frame::test::smooth(size);
        const Decoded from_pixels = decode(*encoder->encode(picture).value());
        const Decoded from_planes = decode(*encoder->encode(as_format(picture, frame::PixelFormat::jpeg_i420)).value());
        EXPECT_GT(psnr(from_pixels.rgba, from_planes.rgba), 45) << size.to_string();
        EXPECT_NEAR(psnr(from_planes.rgba, picture.bytes()), psnr(from_pixels.rgba, picture.bytes()), 0.5);
    }
}

// What guvcview takes for granted: 2x1 luma blocks to one of each chroma, and so two samples a pixel in planes.
TEST(JpegEncoder, Yuv422HasAChromaRowForEachRow) {
    auto encoder = create_jpeg_encoder(90, ChromaSampling::yuv422).value();
    for (const ImageSize size : {ImageSize{320, 240}, {321, 241}, {16, 8}, {33, 7}, {1, 1}, {64, 4096}}) {
        const frame::Frame picture = frame::test::smooth(size);
        for (const frame::PixelFormat format :
             {frame::PixelFormat::rgba8, frame::PixelFormat::bgr24, frame::PixelFormat::jpeg_i420}) {
            const auto jpeg =
                encoder->encode(format == frame::PixelFormat::rgba8 ? picture : as_format(picture, format));
            ASSERT_TRUE(jpeg.has_value()) << jpeg.error().message;
            const Decoded decoded = decode(**jpeg);
            ASSERT_EQ(decoded.size, size);
            EXPECT_EQ(decoded.subsampling, TJSAMP_422);
            EXPECT_GT(psnr(decoded.rgba, picture.bytes()), 30) << size.to_string() << " " << to_string(format);
        }
    }
    EXPECT_EQ(decode(*encoder->encode(as_format(frame::test::smooth({64, 48}), frame::PixelFormat::gray8)).value())
                  .subsampling,
              TJSAMP_GRAY);
}

TEST(JpegEncoder, MakesTheBytesThatTurboJpegMakesOfTheSameSamples) {
    struct Case {
        frame::PixelFormat format;
        ChromaSampling sampling;
        int subsampling;
    };
    for (const ImageSize size : {ImageSize{320, 240}, {321, 241}, {33, 7}, {50, 34}}) {
        for (const Case& one : {Case{frame::PixelFormat::rgba8, ChromaSampling::yuv420, TJSAMP_420},
                                {frame::PixelFormat::rgba8, ChromaSampling::yuv422, TJSAMP_422},
                                {frame::PixelFormat::jpeg_i420, ChromaSampling::yuv420, TJSAMP_420},
                                {frame::PixelFormat::gray8, ChromaSampling::yuv420, TJSAMP_GRAY}}) {
            const frame::Frame picture = as_format(frame::test::noise(size), one.format);
            const BytesRef ours = create_jpeg_encoder(85, one.sampling).value()->encode(picture).value();
            EXPECT_TRUE(std::ranges::equal(*ours, by_turbojpeg(picture, 85, one.subsampling)))
                << size.to_string() << " " << to_string(one.format) << " " << to_string(one.sampling);
        }
    }
}

TEST(JpegEncoder, GrayHasOneComponent) {
    auto encoder = create_jpeg_encoder(90).value();
    EXPECT_EQ(decode(*encoder->encode(as_format(frame::test::smooth({64, 48}), frame::PixelFormat::gray8)).value())
                  .subsampling,
              TJSAMP_GRAY);
}

// RTP/JPEG (RFC 2435) sends no Huffman tables: they must be the standard ones, the picture baseline, and nothing
// optional may stand before the frame header but JFIF's APP0.
TEST(JpegEncoder, HeadersAreWhatRtpAndOldDecodersNeed) {
    auto encoder = create_jpeg_encoder(90).value();
    const BytesRef jpeg = encoder->encode(frame::test::noise({64, 48})).value();
    const auto at = [&](std::size_t i) { return code((*jpeg)[i]); };
    EXPECT_EQ(at(0) << 8 | at(1), 0xffd8);
    EXPECT_EQ(at(jpeg->size() - 2) << 8 | at(jpeg->size() - 1), 0xffd9);
    std::size_t huffman_bytes = 0;
    bool baseline = false;
    for (std::size_t i = 2; at(i + 1) != 0xda; i += 2U + static_cast<std::size_t>(at(i + 2) << 8 | at(i + 3))) {
        ASSERT_EQ(at(i), 0xff);
        const int marker = at(i + 1);
        EXPECT_TRUE(marker == 0xe0 || marker == 0xdb || marker == 0xc0 || marker == 0xc4 || marker == 0xdd)
            << std::hex << marker;
        baseline = baseline || marker == 0xc0;
        if (marker == 0xc4) huffman_bytes += static_cast<std::size_t>(at(i + 2) << 8 | at(i + 3)) - 2;
    }
    EXPECT_TRUE(baseline);
    EXPECT_EQ(huffman_bytes, 2U * (17 + 12) + 2 * (17 + 162)) << "the tables of Annex K";
}

TEST(JpegEncoder, TheSameFrameGivesTheSameBytes) {
    const frame::Frame picture = frame::test::noise({320, 240});
    auto one = create_jpeg_encoder(85).value();
    auto other = create_jpeg_encoder(85).value();
    const BytesRef first = one->encode(picture).value();
    ASSERT_TRUE(one->encode(frame::test::noise({64, 64}, frame::PixelFormat::rgba8, 2)).has_value());
    EXPECT_EQ(*first, *one->encode(picture).value());
    EXPECT_EQ(*first, *other->encode(picture).value());
}

TEST(JpegEncoder, TheCodeStripSurvives) {
    const frame::CodeStrip strip{3, 123456, 987'654'321'012};
    for (const int quality : {10, 50, 90}) {
        auto encoder = create_jpeg_encoder(quality).value();
        for (const ImageSize size : {ImageSize{128, 96}, {320, 240}, {641, 479}, {1920, 1080}}) {
            for (const bool busy : {true, false}) {
                frame::Frame picture = busy ? frame::test::noise(size) : frame::test::smooth(size);
                draw_code_strip(picture.mutable_bytes(), size, strip);
                const Decoded decoded = decode(*encoder->encode(picture).value());
                EXPECT_EQ(frame::read_code_strip(decoded.rgba, size), strip) << quality << " " << size.to_string();

                const ImageSize half{size.width / 2, size.height / 2};
                if (quality < 50 || frame::code_strip_cell(size) < 4) continue;
                std::vector<std::byte> halved(bytes_of(frame::PixelFormat::rgba8, half));
                const frame::Frame received(frame::test::frame_info(size), decoded.rgba);
                ASSERT_TRUE(convert(received, frame::PixelFormat::rgba8, half, halved).has_value());
                EXPECT_EQ(frame::read_code_strip(halved, half), strip) << quality << " halved " << size.to_string();
            }
        }
    }
}

TEST(JpegEncoder, BadInputIsAnError) {
    for (const int quality : {-1, 0, 101}) {
        EXPECT_EQ(create_jpeg_encoder(quality).error().kind, ErrorKind::invalid_argument);
    }
    auto encoder = create_jpeg_encoder(90).value();
    EXPECT_EQ(encoder->encode(frame::test::noise({16, 16}, frame::PixelFormat::depth32f)).error().kind,
              ErrorKind::unsupported);
    EXPECT_EQ(encoder->encode(frame::Frame(frame::test::frame_info({0, 16}), std::vector<std::byte>{})).error().kind,
              ErrorKind::invalid_argument);
    EXPECT_EQ(encoder->encode(frame::test::noise({65501, 1})).error().kind, ErrorKind::invalid_argument);
    EXPECT_TRUE(encoder->encode(frame::test::noise({16, 16})).has_value()) << "and it goes on";
}

}  // namespace
}  // namespace camrig::codec
