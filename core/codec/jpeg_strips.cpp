#include "core/codec/jpeg_strips.h"

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>

// jpeglib.h needs FILE and size_t before it.
#include <jpeglib.h>

namespace camrig::codec {
namespace {

constexpr std::size_t first_capacity = std::size_t{64} << 10;

/// How libjpeg takes a frame's pixels.
struct Layout {
    J_COLOR_SPACE color_space;
    int components;
    bool planes = false;
};

std::optional<Layout> layout_of(frame::PixelFormat format) {
    switch (format) {
        case frame::PixelFormat::rgba8:
            return Layout{JCS_EXT_RGBX, 4};
        case frame::PixelFormat::rgb24:
            return Layout{JCS_EXT_RGB, 3};
        case frame::PixelFormat::bgr24:
            return Layout{JCS_EXT_BGR, 3};
        case frame::PixelFormat::gray8:
            return Layout{JCS_GRAYSCALE, 1};
        case frame::PixelFormat::jpeg_i420:
            return Layout{JCS_YCbCr, 3, true};
        default:
            return std::nullopt;
    }
}

/// libjpeg only reads what it is given, but its pointers are not const.
JSAMPROW samples(const std::byte* bytes) {
    return reinterpret_cast<JSAMPROW>(const_cast<std::byte*>(bytes));
}

int number_at(const std::byte* bytes) {
    return std::to_integer<int>(bytes[0]) << 8 | std::to_integer<int>(bytes[1]);
}

/// Takes apart what libjpeg wrote: segments up to the start of scan, strips with RSTn between, EOI.
void take_apart(std::span<const std::byte> jpeg, JpegStrips& parts) {
    constexpr int sos = 0xffda;
    const std::byte* const begin = jpeg.data();
    const std::byte* const eoi = begin + jpeg.size() - 2;
    const std::byte* at = begin + 2;
    for (int marker = 0; marker != sos; at += 2 + number_at(at + 2)) {
        CHECK(at < eoi);
        marker = number_at(at);
    }
    parts.head = {begin, at};
    parts.strips.clear();
    const std::byte* start = at;
    const auto next_ff = [&] {
        return static_cast<const std::byte*>(std::memchr(at, 0xff, static_cast<std::size_t>(eoi - at)));
    };
    while (at < eoi && (at = next_ff()) != nullptr) {
        // An 0xff of the code itself is followed by 0.
        if (at[1] != std::byte{0}) {
            parts.strips.emplace_back(start, at);
            start = at + 2;
        }
        at += 2;
    }
    parts.strips.emplace_back(start, eoi);
}

}  // namespace

/// libjpeg's state, with errors that come back as values and a buffer that grows to what the pictures need.
struct JpegStripCompressor::Libjpeg {
    /// Rows of a plane as libjpeg wants them given: as many as it asks for, the last one again below the picture, and
    /// each as wide as whole blocks are.
    class PlaneRows {
    public:
        static constexpr int max_rows = jpeg_strip_rows;

        /// Each row of the plane is taken `repeat` times.
        JSAMPARRAY point_at(const std::byte* plane, int width, int height, int first_row, int rows, int repeat = 1) {
            const int blocks_width = (width + DCTSIZE - 1) / DCTSIZE * DCTSIZE;
            if (blocks_width != width) padded_.resize(static_cast<std::size_t>(blocks_width) * max_rows);
            for (int i = 0; i < rows; ++i) {
                const std::byte* row =
                    plane + static_cast<std::ptrdiff_t>(std::min((first_row + i) / repeat, height - 1)) * width;
                if (blocks_width != width) {
                    std::byte* const copy = padded_.data() + static_cast<std::ptrdiff_t>(i) * blocks_width;
                    std::memcpy(copy, row, static_cast<std::size_t>(width));
                    std::fill(copy + width, copy + blocks_width, row[width - 1]);
                    row = copy;
                }
                rows_[static_cast<std::size_t>(i)] = samples(row);
            }
            return rows_.data();
        }

    private:
        std::array<JSAMPROW, max_rows> rows_{};
        std::vector<std::byte> padded_;
    };

    jpeg_compress_struct compress{};
    jpeg_error_mgr errors{};
    jpeg_destination_mgr destination{};
    std::jmp_buf on_error{};
    int quality = 0;
    ChromaSampling sampling{};
    std::vector<std::byte> bytes;
    std::array<PlaneRows, 3> planes;

    static Libjpeg& of(j_common_ptr common) { return *static_cast<Libjpeg*>(common->client_data); }
    static Libjpeg& of(j_compress_ptr compressor) { return *static_cast<Libjpeg*>(compressor->client_data); }

    bool create() {
        compress.err = jpeg_std_error(&errors);
        errors.error_exit = [](j_common_ptr common) { std::longjmp(of(common).on_error, 1); };
        errors.output_message = [](j_common_ptr) {};
        compress.client_data = this;
        if (setjmp(on_error) != 0) return false;
        jpeg_create_compress(&compress);  // leaves client_data and err as they are
        destination.init_destination = [](j_compress_ptr c) { of(c).give_room_after(0); };
        destination.empty_output_buffer = [](j_compress_ptr c) -> boolean {
            of(c).give_room_after(of(c).bytes.size());
            return TRUE;
        };
        destination.term_destination = [](j_compress_ptr) {};
        compress.dest = &destination;
        return true;
    }

    void give_room_after(std::size_t used) {
        if (bytes.size() == used) bytes.resize(std::max(first_capacity, 2 * used));
        destination.next_output_byte = reinterpret_cast<JOCTET*>(bytes.data() + used);
        destination.free_in_buffer = bytes.size() - used;
    }

    /// Nothing in here has a destructor: an error jumps out of it.
    bool write(const frame::Frame& frame, const Layout& layout, int first_row, int end_row) {
        if (setjmp(on_error) != 0) {
            jpeg_abort_compress(&compress);
            return false;
        }
        compress.image_width = static_cast<JDIMENSION>(frame.info().size.width);
        compress.image_height = static_cast<JDIMENSION>(end_row - first_row);
        compress.input_components = layout.components;
        compress.in_color_space = layout.color_space;
        jpeg_set_defaults(&compress);
        jpeg_set_quality(&compress, quality, TRUE);
        // With AVX2 the fast one gains nothing (measured with libjpeg-turbo 2.1.5) and costs up to several dB at high
        // qualities.
        compress.dct_method = JDCT_ISLOW;
        compress.raw_data_in = layout.planes ? TRUE : FALSE;
        // jpeg_set_defaults() gave colour pictures 2x2 luma blocks to one of each chroma.
        if (layout.components > 1 && sampling == ChromaSampling::yuv422) compress.comp_info[0].v_samp_factor = 1;
        compress.restart_in_rows = jpeg_strip_rows / mcu_rows();
        jpeg_start_compress(&compress, TRUE);
        layout.planes ? write_planes(frame, first_row, end_row) : write_pixels(frame, layout, first_row, end_row);
        jpeg_finish_compress(&compress);
        return true;
    }

    /// Rows of a minimum coded unit: what libjpeg takes of planes at one time.
    int mcu_rows() const { return DCTSIZE * compress.comp_info[0].v_samp_factor; }

    void write_pixels(const frame::Frame& frame, const Layout& layout, int first_row, int end_row) {
        const std::ptrdiff_t stride = static_cast<std::ptrdiff_t>(frame.info().size.width) * layout.components;
        JSAMPROW rows[jpeg_strip_rows];
        for (int y = first_row; y < end_row; y += jpeg_strip_rows) {
            const int count = std::min(jpeg_strip_rows, end_row - y);
            for (int i = 0; i < count; ++i) rows[i] = samples(frame.bytes().data() + (y + i) * stride);
            jpeg_write_scanlines(&compress, rows, static_cast<JDIMENSION>(count));
        }
    }

    void write_planes(const frame::Frame& frame, int first_row, int end_row) {
        const auto [width, height] = frame.info().size;
        const int half_width = (width + 1) / 2, half_height = (height + 1) / 2;
        const std::byte* const luma = frame.bytes().data();
        const std::byte* const u = luma + frame.info().size.pixels();
        const std::byte* const v = u + static_cast<std::ptrdiff_t>(half_width) * half_height;
        const int mcu = mcu_rows(), lumas_per_chroma = mcu / DCTSIZE, repeat = 2 / lumas_per_chroma;
        for (int y = first_row; y < end_row; y += mcu) {
            JSAMPARRAY rows[3] = {
                planes[0].point_at(luma, width, height, y, mcu),
                planes[1].point_at(u, half_width, half_height, y / lumas_per_chroma, DCTSIZE, repeat),
                planes[2].point_at(v, half_width, half_height, y / lumas_per_chroma, DCTSIZE, repeat),
            };
            jpeg_write_raw_data(&compress, rows, static_cast<JDIMENSION>(mcu));
        }
    }

    std::string message() {
        char text[JMSG_LENGTH_MAX];
        errors.format_message(reinterpret_cast<j_common_ptr>(&compress), text);
        return std::string("jpeg: ") + text;
    }
};

JpegStripCompressor::JpegStripCompressor(std::unique_ptr<Libjpeg> libjpeg) : libjpeg_(std::move(libjpeg)) {}

JpegStripCompressor::~JpegStripCompressor() {
    jpeg_destroy_compress(&libjpeg_->compress);
}

Result<std::unique_ptr<JpegStripCompressor>> JpegStripCompressor::create(int quality, ChromaSampling sampling) {
    auto libjpeg = std::make_unique<Libjpeg>();
    libjpeg->quality = quality;
    libjpeg->sampling = sampling;
    if (!libjpeg->create()) return error(ErrorKind::resource_exhausted, libjpeg->message());
    return std::unique_ptr<JpegStripCompressor>(new JpegStripCompressor(std::move(libjpeg)));
}

Result<const JpegStrips*> JpegStripCompressor::compress(const frame::Frame& frame, int first_row, int end_row) {
    const frame::FrameInfo& info = frame.info();
    if (info.size.width < 1 || info.size.height < 1 || info.size.width > JPEG_MAX_DIMENSION ||
        info.size.height > JPEG_MAX_DIMENSION) {
        return error(ErrorKind::invalid_argument, "jpeg: no picture of " + info.size.to_string());
    }
    const auto layout = layout_of(info.format);
    if (!layout) {
        return error(ErrorKind::unsupported, "jpeg: cannot encode " + std::string(to_string(info.format)) +
                                                 "; convert it to rgba8, bgr24, rgb24, gray8 or jpeg_i420 first");
    }
    CHECK(first_row % jpeg_strip_rows == 0 && first_row < end_row && end_row <= info.size.height);
    CHECK(end_row % jpeg_strip_rows == 0 || end_row == info.size.height);
    if (!libjpeg_->write(frame, *layout, first_row, end_row)) return error(ErrorKind::internal, libjpeg_->message());
    const std::size_t written = libjpeg_->bytes.size() - libjpeg_->destination.free_in_buffer;
    take_apart(std::span(libjpeg_->bytes).first(written), strips_);
    return &strips_;
}

}  // namespace camrig::codec
