#include "v4l2_sink/preload/device_modes.h"

#include <algorithm>

#include <linux/videodev2.h>

#include "v4l2_sink/media_format.h"

namespace camrig::device {

namespace {

/// Fractions of the camera's size that are offered.
struct Fraction {
    int num, den;
};
constexpr std::array<Fraction, 6> fractions{{{3, 4}, {2, 3}, {1, 2}, {1, 3}, {1, 4}, {1, 8}}};
constexpr std::array<int, 10> usual_rates{{60, 50, 30, 25, 20, 15, 10, 5, 2, 1}};
constexpr int jpeg_headroom = 4096;

}  // namespace

const std::array<std::uint32_t, 5> device_fourccs{V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_YUV420,
                                                  V4L2_PIX_FMT_NV12, V4L2_PIX_FMT_BGR24};

DeviceModes modes_of(const stream::CameraStream& camera) {
    DeviceModes modes;
    const ImageSize own{camera.size.width & ~1, camera.size.height & ~1};
    modes.sizes.push_back(own);
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
    return media_format_of(format.fourcc, {static_cast<int>(format.width), static_cast<int>(format.height)},
                           mjpg_sampling);
}

std::uint32_t picture_bytes(const camrig_format& format) {
    const auto media = media_format_of(format, codec::ChromaSampling::yuv422);
    if (!media) return 0;
    if (media->codec == codec::Codec::jpeg) return 2 * format.width * format.height + jpeg_headroom;
    return static_cast<std::uint32_t>(bytes_of(media->pixels, media->size));
}

}  // namespace camrig::device
