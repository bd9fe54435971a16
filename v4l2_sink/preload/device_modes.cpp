#include "v4l2_sink/preload/device_modes.h"

#include <algorithm>
#include <array>
#include <iterator>

#include <linux/videodev2.h>

#include "v4l2_sink/media_format.h"
#include "v4l2_sink/preload/number_fourccs.h"

namespace camrig::device {

namespace {

/// Fractions of the camera's size that are offered.
struct Fraction {
    int num, den;
};
constexpr std::array<Fraction, 6> fractions{{{3, 4}, {2, 3}, {1, 2}, {1, 3}, {1, 4}, {1, 8}}};
constexpr std::array<int, 10> usual_rates{{60, 50, 30, 25, 20, 15, 10, 5, 2, 1}};
constexpr int jpeg_headroom = 4096;
constexpr std::array<std::uint32_t, 5> picture_fourccs{V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_YUV420,
                                                       V4L2_PIX_FMT_NV12, V4L2_PIX_FMT_BGR24};

frame::PixelFormat layout_of(Mosaic mosaic) {
    switch (mosaic) {
        case Mosaic::none:
            return frame::PixelFormat::gray16;
        case Mosaic::rggb:
            return frame::PixelFormat::bayer_rggb16;
        case Mosaic::grbg:
            return frame::PixelFormat::bayer_grbg16;
        case Mosaic::gbrg:
            return frame::PixelFormat::bayer_gbrg16;
        case Mosaic::bggr:
            return frame::PixelFormat::bayer_bggr16;
    }
    CHECK(!"a mosaic");
    return frame::PixelFormat::gray16;
}

/// The sensor's own bits first, or the next that have a name; then the widest and the narrowest.
std::vector<std::uint32_t> fourccs_of(const stream::SensorNumbers& numbers) {
    std::vector<std::uint32_t> fourccs;
    const auto add = [&](int bits) {
        for (const NumberFourcc& one : number_fourccs) {
            if (layout_of(one.mosaic) != numbers.pixels || one.bits < bits) continue;
            if (std::ranges::find(fourccs, one.fourcc) == fourccs.end()) fourccs.push_back(one.fourcc);
            return;
        }
    };
    for (const int bits : {numbers.bits, 16, 8}) add(bits);
    return fourccs;
}

}  // namespace

DeviceModes modes_of(const stream::CameraStream& camera) {
    DeviceModes modes;
    modes.fourccs.assign(picture_fourccs.begin(), picture_fourccs.end());
    const ImageSize own{camera.size.width & ~1, camera.size.height & ~1};
    modes.sizes.push_back(own);
    if (camera.numbers && own == camera.size)
        std::ranges::copy(fourccs_of(*camera.numbers), std::back_inserter(modes.fourccs));
    for (const Fraction& f : fractions) {
        if (own.width * f.num % f.den != 0 || own.height * f.num % f.den != 0) continue;
        const ImageSize size{own.width * f.num / f.den, own.height * f.num / f.den};
        if (size.width % 2 != 0 || size.height % 2 != 0) continue;
        if (size.width < min_image_size.width || size.height < min_image_size.height) continue;
        modes.sizes.push_back(size);
    }
    modes.rates.push_back(camera.rate);
    for (const int usual : usual_rates)
        if (usual < camera.rate.hertz()) modes.rates.push_back(*Rate::create(usual, 1));
    return modes;
}

std::optional<stream::MediaFormat> media_format_of(const camrig_format& format, codec::ChromaSampling mjpg_sampling) {
    const ImageSize size{static_cast<int>(format.width), static_cast<int>(format.height)};
    if (const NumberFourcc* const numbers = number_fourcc(format.fourcc)) {
        stream::MediaFormat media;
        media.pixels = layout_of(numbers->mosaic);
        media.number_bits = numbers->bits;
        media.size = size;
        return media;
    }
    return media_format_of(format.fourcc, size, mjpg_sampling);
}

std::uint32_t picture_bytes(const camrig_format& format) {
    const auto media = media_format_of(format, codec::ChromaSampling::yuv422);
    if (!media) return 0;
    if (const NumberFourcc* const numbers = number_fourcc(format.fourcc))
        return bytes_a_number(*numbers) * format.width * format.height;
    if (media->codec == codec::Codec::jpeg) return 2 * format.width * format.height + jpeg_headroom;
    return static_cast<std::uint32_t>(bytes_of(media->pixels, media->size));
}

}  // namespace camrig::device
