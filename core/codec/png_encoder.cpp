#include <cmath>
#include <csetjmp>
#include <limits>
#include <string>

#include <png.h>

#include "core/codec/bytes_recycler.h"
#include "core/codec/encoder.h"

namespace camrig {
namespace {

/// All that one PNG needs. Kept outside the function that calls setjmp, so that nothing of it lives on the stack that
/// libpng's longjmp jumps over.
struct Job {
    ImageSize size;
    const std::byte* pixels = nullptr;
    int pixel_bytes = 0;  ///< of a pixel in `pixels`
    int color_type = PNG_COLOR_TYPE_RGB;
    int bit_depth = 8;
    bool bgr = false;
    int level = 1;
    std::vector<std::byte>* out = nullptr;
    std::string message;
    std::jmp_buf failed;
};

void on_write(png_structp png, png_bytep data, png_size_t length) {
    auto& out = *static_cast<Job*>(png_get_io_ptr(png))->out;
    const auto* const bytes = reinterpret_cast<const std::byte*>(data);
    out.insert(out.end(), bytes, bytes + length);
}
void on_flush(png_structp) {}
void on_error(png_structp png, png_const_charp message) {
    auto& job = *static_cast<Job*>(png_get_error_ptr(png));
    job.message = message;
    std::longjmp(job.failed, 1);
}
void on_warning(png_structp, png_const_charp) {}

void write_rows(png_structp png, png_infop info, const Job& job) {
    png_set_write_fn(png, const_cast<Job*>(&job), on_write, on_flush);
    // Rendered pictures are smooth: "sub" (difference to the left neighbour) compresses nearly as well as libpng's
    // search among all filters and costs a fraction of it. At level 0 nothing is gained by any.
    png_set_filter(png, PNG_FILTER_TYPE_BASE, job.level == 0 ? PNG_FILTER_NONE : PNG_FILTER_SUB);
    png_set_compression_level(png, job.level);
    png_set_compression_buffer_size(png, 1 << 16);
    png_set_IHDR(png, info, static_cast<png_uint_32>(job.size.width), static_cast<png_uint_32>(job.size.height),
                 job.bit_depth, job.color_type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    if (job.bit_depth == 8) png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(png, info);
    if (job.pixel_bytes == 4) png_set_filler(png, 0, PNG_FILLER_AFTER);
    if (job.bgr) png_set_bgr(png);
    const auto row_bytes = static_cast<std::ptrdiff_t>(job.size.width) * job.pixel_bytes;
    for (int y = 0; y < job.size.height; ++y) {
        png_write_row(png, reinterpret_cast<png_const_bytep>(job.pixels + y * row_bytes));
    }
    png_write_end(png, info);
}

bool write_png(Job& job) {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &job, on_error, on_warning);
    png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
    if (info == nullptr) {
        png_destroy_write_struct(&png, nullptr);
        job.message = "out of memory";
        return false;
    }
    if (setjmp(job.failed) != 0) {
        png_destroy_write_struct(&png, &info);
        return false;
    }
    write_rows(png, info, job);
    png_destroy_write_struct(&png, &info);
    return true;
}

void put_u16(std::byte* out, std::uint32_t value) {
    out[0] = static_cast<std::byte>(value >> 8);
    out[1] = static_cast<std::byte>(value & 255U);
}

class PngEncoder : public Encoder {
public:
    explicit PngEncoder(int level) { job_.level = level; }

    Result<BytesRef> encode(const Frame& frame) override {
        if (auto good = prepare(frame); !good) return std::unexpected(good.error());
        auto out = recycler_.acquire();
        job_.out = out.get();
        if (!write_png(job_)) return error(ErrorKind::internal, "png: " + job_.message);
        return out;
    }

private:
    Result<void> prepare(const Frame& frame) {
        const FrameInfo& info = frame.info();
        if (info.size.width < 1 || info.size.height < 1) {
            return error(ErrorKind::invalid_argument, "png: no picture of " + info.size.to_string());
        }
        job_.size = info.size;
        job_.pixels = frame.bytes().data();
        job_.bgr = info.format == PixelFormat::bgr24;
        job_.bit_depth = 8;
        job_.color_type = PNG_COLOR_TYPE_RGB;
        switch (info.format) {
            case PixelFormat::rgba8:
                job_.pixel_bytes = 4;
                return {};
            case PixelFormat::rgb24:
            case PixelFormat::bgr24:
                job_.pixel_bytes = 3;
                return {};
            case PixelFormat::gray8:
                job_.pixel_bytes = 1;
                job_.color_type = PNG_COLOR_TYPE_GRAY;
                return {};
            case PixelFormat::depth32f:
                return prepare_depth(frame);
            case PixelFormat::id32:
                return prepare_ids(frame);
            default:
                return error(ErrorKind::unsupported, "png: cannot encode " + std::string(to_string(info.format)) +
                                                         "; it takes rgba8, rgb24, bgr24, gray8, depth32f and id32");
        }
    }

    void use_gray16() {
        job_.pixels = gray16_.data();
        job_.pixel_bytes = 2;
        job_.bit_depth = 16;
        job_.color_type = PNG_COLOR_TYPE_GRAY;
    }

    Result<void> prepare_depth(const Frame& frame) {
        const auto* const metres = reinterpret_cast<const float*>(frame.bytes().data());
        const auto pixels = static_cast<std::size_t>(frame.info().size.pixels());
        gray16_.resize(pixels * 2);
        for (std::size_t i = 0; i < pixels; ++i) {
            const double mm = std::round(static_cast<double>(metres[i]) * 1000.0);
            const bool shown = mm > 0 && mm <= std::numeric_limits<std::uint16_t>::max();  // false for NaN
            put_u16(gray16_.data() + 2 * i, shown ? static_cast<std::uint32_t>(mm) : 0U);
        }
        use_gray16();
        return {};
    }

    Result<void> prepare_ids(const Frame& frame) {
        const auto* const ids = reinterpret_cast<const std::uint32_t*>(frame.bytes().data());
        const auto pixels = static_cast<std::size_t>(frame.info().size.pixels());
        gray16_.resize(pixels * 2);
        for (std::size_t i = 0; i < pixels; ++i) {
            if (ids[i] > std::numeric_limits<std::uint16_t>::max()) {
                return error(ErrorKind::unsupported, "png: the id " + std::to_string(ids[i]) +
                                                         " does not fit into 16 bits; ask for the raw frame");
            }
            put_u16(gray16_.data() + 2 * i, ids[i]);
        }
        use_gray16();
        return {};
    }

    Job job_;
    std::vector<std::byte> gray16_;
    BytesRecycler recycler_;
};

}  // namespace

Result<std::unique_ptr<Encoder>> create_png_encoder(int level) {
    if (level < 0 || level > 9) {
        return error(ErrorKind::invalid_argument,
                     "png: level is " + std::to_string(level) + "; it goes from 0 (stored) to 9 (smallest)");
    }
    return std::make_unique<PngEncoder>(level);
}

}  // namespace camrig
