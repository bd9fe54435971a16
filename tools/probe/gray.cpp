#include "tools/probe/gray.h"

#include <cstring>
#include <memory>
#include <type_traits>

#include <linux/videodev2.h>
#include <turbojpeg.h>

namespace camrig::probe {
namespace {

constexpr int max_side = 16384;

/// Where the brightness lies in a row: every `step` bytes from `first` on. Step 0: a format without that.
struct GrayLayout {
    std::size_t first = 0;
    std::size_t step = 0;
};

GrayLayout layout_of_fourcc(std::uint32_t fourcc) {
    switch (fourcc) {
        case V4L2_PIX_FMT_YUYV:
        case V4L2_PIX_FMT_YVYU:
            return {0, 2};
        case V4L2_PIX_FMT_UYVY:
        case V4L2_PIX_FMT_VYUY:
            return {1, 2};
        case V4L2_PIX_FMT_YUV420:
        case V4L2_PIX_FMT_YVU420:
        case V4L2_PIX_FMT_YUV422P:
        case V4L2_PIX_FMT_NV12:
        case V4L2_PIX_FMT_NV21:
        case V4L2_PIX_FMT_NV16:
        case V4L2_PIX_FMT_GREY:
            return {0, 1};
        case V4L2_PIX_FMT_BGR24:
        case V4L2_PIX_FMT_RGB24:
            return {1, 3};
        case V4L2_PIX_FMT_XBGR32:
        case V4L2_PIX_FMT_ABGR32:
            return {1, 4};
        default:
            return {};
    }
}

}  // namespace

bool gray_from_raw(std::uint32_t fourcc, std::span<const std::byte> bytes, ImageSize size, std::size_t row_bytes,
                   std::vector<std::byte>& gray) {
    const GrayLayout layout = layout_of_fourcc(fourcc);
    if (layout.step == 0 || size.width <= 0 || size.height <= 0) return false;
    const auto width = static_cast<std::size_t>(size.width), height = static_cast<std::size_t>(size.height);
    const std::size_t used = width * layout.step;
    if (row_bytes == 0) row_bytes = used;
    if (row_bytes < used || bytes.size() < (height - 1) * row_bytes + used) return false;
    gray.resize(width * height);
    for (std::size_t y = 0; y < height; ++y) {
        const std::byte* from = bytes.data() + y * row_bytes + layout.first;
        std::byte* to = gray.data() + y * width;
        if (layout.step == 1) {
            std::memcpy(to, from, width);
        } else {
            for (std::size_t x = 0; x < width; ++x) to[x] = from[x * layout.step];
        }
    }
    return true;
}

bool gray_from_jpeg(std::span<const std::byte> jpeg, ImageSize& size, std::vector<std::byte>& gray) {
    const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), tjDestroy);
    const auto* bytes = reinterpret_cast<const unsigned char*>(jpeg.data());
    int sampling = 0, colors = 0;
    if (!decoder ||
        tjDecompressHeader3(decoder.get(), bytes, jpeg.size(), &size.width, &size.height, &sampling, &colors) != 0)
        return false;
    if (size.width <= 0 || size.height <= 0 || size.width > max_side || size.height > max_side) return false;
    gray.resize(static_cast<std::size_t>(size.pixels()));
    // Fails on warnings too: a JPEG that ends early is decoded, with a grey rest.
    return tjDecompress2(decoder.get(), bytes, jpeg.size(), reinterpret_cast<unsigned char*>(gray.data()), size.width,
                         size.width, size.height, TJPF_GRAY, 0) == 0;
}

}  // namespace camrig::probe
