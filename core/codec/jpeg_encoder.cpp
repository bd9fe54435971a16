#include <algorithm>
#include <cstring>
#include <string>

#include <turbojpeg.h>

#include "core/codec/bytes_recycler.h"
#include "core/codec/encoder.h"

namespace camrig {
namespace {

const std::uint8_t* as_u8(const std::byte* bytes) {
    return reinterpret_cast<const std::uint8_t*>(bytes);
}

struct TurboJpegDeleter {
    void operator()(void* handle) const { tjDestroy(handle); }
};
using TurboJpeg = std::unique_ptr<void, TurboJpegDeleter>;

/// The accurate integer DCT: with AVX2 the fast one gains nothing (measured with libjpeg-turbo 2.1.5) and costs up to
/// several dB at high qualities.
constexpr int flags = TJFLAG_ACCURATEDCT | TJFLAG_NOREALLOC;

class JpegEncoder : public Encoder {
public:
    JpegEncoder(TurboJpeg compressor, int quality) : compressor_(std::move(compressor)), quality_(quality) {}

    Result<BytesRef> encode(const Frame& frame) override {
        const FrameInfo& info = frame.info();
        // 65500 is libjpeg's own limit (JPEG_MAX_DIMENSION).
        if (info.size.width < 1 || info.size.height < 1 || info.size.width > 65500 || info.size.height > 65500) {
            return error(ErrorKind::invalid_argument, "jpeg: no picture of " + info.size.to_string());
        }
        reserve(info.size);
        unsigned long bytes = capacity_;
        int failed = 0;
        switch (info.format) {
            case PixelFormat::rgba8:
                failed = compress(frame, TJPF_RGBX, 4, TJSAMP_420, bytes);
                break;
            case PixelFormat::rgb24:
                failed = compress(frame, TJPF_RGB, 3, TJSAMP_420, bytes);
                break;
            case PixelFormat::bgr24:
                failed = compress(frame, TJPF_BGR, 3, TJSAMP_420, bytes);
                break;
            case PixelFormat::gray8:
                failed = compress(frame, TJPF_GRAY, 1, TJSAMP_GRAY, bytes);
                break;
            case PixelFormat::jpeg_i420:
                failed = compress_planes(frame, bytes);
                break;
            default:
                return error(ErrorKind::unsupported,
                             "jpeg: cannot encode " + std::string(to_string(info.format)) +
                                 "; convert it to rgba8, bgr24, rgb24, gray8 or jpeg_i420 first");
        }
        if (failed != 0) {
            return error(ErrorKind::internal, std::string("jpeg: ") + tjGetErrorStr2(compressor_.get()));
        }
        return recycler_.copy_of(std::span(buffer_.get(), bytes));
    }

private:
    /// Room for the worst case, so that the compressor never allocates. Left uninitialised: only the pages that a
    /// picture really fills are ever touched.
    void reserve(ImageSize size) {
        const unsigned long needed = tjBufSize(size.width, size.height, TJSAMP_420);
        if (needed <= capacity_) return;
        buffer_ = std::make_unique_for_overwrite<std::byte[]>(needed);
        capacity_ = needed;
    }

    int compress(const Frame& frame, int pixel_format, int pixel_bytes, int sampling, unsigned long& bytes) {
        const auto [width, height] = frame.info().size;
        auto* target = reinterpret_cast<unsigned char*>(buffer_.get());
        return tjCompress2(compressor_.get(), as_u8(frame.bytes().data()), width, width * pixel_bytes, height,
                           pixel_format, &target, &bytes, sampling, quality_, flags);
    }

    int compress_planes(const Frame& frame, unsigned long& bytes) {
        const auto [width, height] = frame.info().size;
        const int half_width = (width + 1) / 2;
        const std::uint8_t* const luma = as_u8(frame.bytes().data());
        const std::uint8_t* const u = luma + frame.info().size.pixels();
        const std::uint8_t* const v = u + static_cast<std::ptrdiff_t>(half_width) * ((height + 1) / 2);
        const unsigned char* planes[3] = {luma, u, v};
        const int strides[3] = {width, half_width, half_width};
        auto* target = reinterpret_cast<unsigned char*>(buffer_.get());
        if (width % 2 == 0 && height % 2 == 0) {
            return tjCompressFromYUVPlanes(compressor_.get(), planes, width, strides, height, TJSAMP_420, &target,
                                           &bytes, quality_, flags);
        }
        // TurboJPEG wants a luma plane of even size and would read past ours.
        const int even_strides[3] = {pad_luma(luma, width, height), half_width, half_width};
        planes[0] = as_u8(even_luma_.data());
        return tjCompressFromYUVPlanes(compressor_.get(), planes, width, even_strides, height, TJSAMP_420, &target,
                                       &bytes, quality_, flags);
    }

    /// Fills even_luma_ with the plane and a copy of its last column and row; returns its width.
    int pad_luma(const std::uint8_t* luma, int width, int height) {
        const int even_width = width + width % 2;
        const int even_height = height + height % 2;
        even_luma_.resize(static_cast<std::size_t>(even_width) * static_cast<std::size_t>(even_height));
        for (int y = 0; y < even_height; ++y) {
            const std::uint8_t* const from = luma + static_cast<std::ptrdiff_t>(std::min(y, height - 1)) * width;
            std::byte* const to = even_luma_.data() + static_cast<std::ptrdiff_t>(y) * even_width;
            std::memcpy(to, from, static_cast<std::size_t>(width));
            to[even_width - 1] = std::byte{from[width - 1]};
        }
        return even_width;
    }

    TurboJpeg compressor_;
    int quality_;
    std::unique_ptr<std::byte[]> buffer_;
    unsigned long capacity_ = 0;
    std::vector<std::byte> even_luma_;
    BytesRecycler recycler_;
};

}  // namespace

Result<std::unique_ptr<Encoder>> create_jpeg_encoder(int quality) {
    if (quality < 1 || quality > 100) {
        return error(ErrorKind::invalid_argument,
                     "jpeg: quality is " + std::to_string(quality) + "; it goes from 1 to 100");
    }
    TurboJpeg compressor(tjInitCompress());
    if (!compressor) return error(ErrorKind::resource_exhausted, std::string("jpeg: ") + tjGetErrorStr2(nullptr));
    return std::make_unique<JpegEncoder>(std::move(compressor), quality);
}

}  // namespace camrig
