#include <algorithm>
#include <string>

#include "core/codec/bytes_recycler.h"
#include "core/codec/encoder.h"
#include "core/codec/jpeg_strips.h"

// A standing camera's picture differs from its last one where something moved. Its JPEG is made of strips of 16 rows
// with restart markers between, which depend on nothing outside of their rows: those that did not change are copied
// from the last JPEG, the others are compressed. The result is, byte for byte, what compressing the whole picture
// gives.
namespace camrig::codec {
namespace {

class JpegEncoder : public Encoder {
public:
    explicit JpegEncoder(std::unique_ptr<JpegStripCompressor> compressor) : compressor_(std::move(compressor)) {}

    Result<BytesRef> encode(const frame::Frame& frame) override {
        const frame::FrameInfo& info = frame.info();
        const int strip_count = (info.size.height + jpeg_strip_rows - 1) / jpeg_strip_rows;
        const bool knows_the_rest = last_.jpeg && info.format == last_.info.format && is_damage_since(last_.info, info);
        const auto is_kept = [&](int strip) { return knows_the_rest && !info.damage.contains_band(strip); };

        int first_changed = 0;
        while (first_changed < strip_count && is_kept(first_changed)) ++first_changed;
        if (knows_the_rest && first_changed == strip_count) {
            last_.info = info;
            return last_.jpeg;
        }

        auto jpeg = recycler_.acquire();
        starts_.clear();
        if (knows_the_rest) append(*jpeg, last_.head());
        for (int strip = 0; strip < strip_count;) {
            if (is_kept(strip)) {
                append_strip(*jpeg, last_.strip(strip));
                ++strip;
                continue;
            }
            int end = strip + 1;
            while (end < strip_count && !is_kept(end)) ++end;
            const int end_row = std::min(end * jpeg_strip_rows, info.size.height);
            const auto made = compressor_->compress(frame, strip * jpeg_strip_rows, end_row);
            if (!made) return std::unexpected(made.error());
            if (jpeg->empty()) append(*jpeg, (*made)->head);
            for (const auto bytes : (*made)->strips) append_strip(*jpeg, bytes);
            strip = end;
        }
        append_marker(*jpeg, 0xd9);
        CHECK(std::ssize(starts_) == strip_count);

        std::swap(last_.starts, starts_);
        last_.info = info;
        last_.jpeg = std::move(jpeg);
        return last_.jpeg;
    }

private:
    /// The last JPEG made, with what it shows.
    struct Last {
        frame::FrameInfo info;
        BytesRef jpeg;
        std::vector<std::size_t> starts;  ///< of each strip's bytes in it

        std::span<const std::byte> head() const { return std::span(*jpeg).first(starts.front()); }
        /// Two bytes of a marker stand after each.
        std::span<const std::byte> strip(int i) const {
            const auto n = static_cast<std::size_t>(i);
            const std::size_t end = n + 1 < starts.size() ? starts[n + 1] : jpeg->size();
            return std::span(*jpeg).subspan(starts[n], end - 2 - starts[n]);
        }
    };

    static void append(std::vector<std::byte>& jpeg, std::span<const std::byte> bytes) {
        jpeg.insert(jpeg.end(), bytes.begin(), bytes.end());
    }
    static void append_marker(std::vector<std::byte>& jpeg, int code) {
        jpeg.push_back(std::byte{0xff});
        jpeg.push_back(static_cast<std::byte>(code));
    }
    void append_strip(std::vector<std::byte>& jpeg, std::span<const std::byte> bytes) {
        if (!starts_.empty()) append_marker(jpeg, 0xd0 + static_cast<int>((starts_.size() - 1) % 8));
        starts_.push_back(jpeg.size());
        append(jpeg, bytes);
    }

    std::unique_ptr<JpegStripCompressor> compressor_;
    Last last_;
    std::vector<std::size_t> starts_;  ///< of the JPEG that is being made
    BytesRecycler recycler_;
};

}  // namespace

Result<std::unique_ptr<Encoder>> create_jpeg_encoder(int quality, ChromaSampling sampling) {
    if (quality < 1 || quality > 100) {
        return error(ErrorKind::invalid_argument,
                     "jpeg: quality is " + std::to_string(quality) + "; it goes from 1 to 100");
    }
    auto compressor = JpegStripCompressor::create(quality, sampling);
    if (!compressor) return std::unexpected(compressor.error());
    return std::make_unique<JpegEncoder>(std::move(*compressor));
}

}  // namespace camrig::codec
