#include "core/stream/transcoder.h"

#include "core/base/clock.h"
#include "core/frame/convert.h"
#include "core/frame/numbers.h"

namespace camrig::stream {
namespace {

class ScopedTimer {
public:
    explicit ScopedTimer(StageTimer& timer) : timer_(timer) {}
    ~ScopedTimer() { timer_.record(monotonic_now_ns() - start_ns_); }

private:
    StageTimer& timer_;
    TimeNs start_ns_ = monotonic_now_ns();
};

}  // namespace

Result<std::unique_ptr<Transcoder>> Transcoder::create(const MediaFormat& format,
                                                       std::shared_ptr<frame::FramePool> pool,
                                                       std::shared_ptr<TranscodeTimers> timers) {
    const bool own_size = format.size == ImageSize{};
    if (!own_size && (format.size.width < min_image_size.width || format.size.height < min_image_size.height ||
                      format.size.width > max_image_size.width || format.size.height > max_image_size.height)) {
        return error(ErrorKind::invalid_argument, "size " + format.size.to_string() + " is out of range; use " +
                                                      min_image_size.to_string() + " to " + max_image_size.to_string());
    }
    std::unique_ptr<Transcoder> transcoder(new Transcoder);
    transcoder->format_ = format;
    transcoder->pool_ = std::move(pool);
    transcoder->timers_ = std::move(timers);
    if (format.codec != codec::Codec::raw) {
        auto encoder = format.codec == codec::Codec::jpeg ? create_jpeg_encoder(format.quality, format.sampling)
                                                          : codec::create_png_encoder();
        if (!encoder) return std::unexpected(encoder.error());
        transcoder->encoder_ = std::move(*encoder);
    }
    return transcoder;
}

Result<MediaUnit> Transcoder::transcode(const frame::FrameRef& frame) {
    frame::FrameRef current = frame;
    if (format_.number_bits != 0) {
        const ScopedTimer timer(timers_->convert);
        auto numbers = numbers_in(*pool_, current, format_.number_bits);
        if (!numbers) return std::unexpected(numbers.error());
        return MediaUnit{.info = (*numbers)->info(), .bytes = {}, .frame = *numbers, .latch = {}};
    }
    const ImageSize size = format_.size == ImageSize{} ? frame->info().size : format_.size;
    const bool is_color = frame->info().kind == frame::FrameKind::color;
    const frame::PixelFormat pixels =
        format_.codec == codec::Codec::raw && is_color ? format_.pixels : frame->info().format;
    if (size != frame->info().size || pixels != frame->info().format) {
        const ScopedTimer timer(timers_->convert);
        auto converted_frame = converted(*pool_, current, pixels, size, last_converted_);
        if (!converted_frame) return std::unexpected(converted_frame.error());
        current = std::move(*converted_frame);
        // Kept only where damage is known: a picture for each output is memory.
        last_converted_ = current->info().damage.base() ? current : nullptr;
    } else {
        last_converted_ = nullptr;
    }
    MediaUnit unit;
    unit.info = current->info();
    if (!encoder_) {
        unit.frame = std::move(current);
        return unit;
    }
    const ScopedTimer timer(timers_->encode);
    auto bytes = encoder_->encode(*current);
    if (!bytes) return std::unexpected(bytes.error());
    unit.bytes = std::move(*bytes);
    return unit;
}

Result<std::unique_ptr<Transcoder>> Transcoder::of_size(ImageSize size) const {
    MediaFormat format = format_;
    format.size = size;
    return create(format, pool_, timers_);
}

frame::PixelFormat source_format(const MediaFormat& format, ImageSize camera_size) {
    const bool is_scaled = format.size != ImageSize{} && format.size != camera_size;
    if (format.number_bits != 0) return format.pixels;
    if (is_scaled || format.codec == codec::Codec::png) return frame::PixelFormat::rgba8;
    if (format.codec != codec::Codec::jpeg) return format.pixels;
    return format.sampling == codec::ChromaSampling::yuv420 ? frame::PixelFormat::jpeg_i420 : frame::PixelFormat::rgba8;
}

std::string describe(const MediaFormat& format) {
    std::string text(to_string(format.codec));
    if (format.codec == codec::Codec::raw) text += " " + std::string(to_string(format.pixels));
    if (format.number_bits != 0) text += " of " + std::to_string(format.number_bits) + " bits";
    if (format.codec == codec::Codec::jpeg)
        text += " q" + std::to_string(format.quality) + " " + std::string(to_string(format.sampling));
    if (format.size != ImageSize{}) text += " " + format.size.to_string();
    return text;
}

}  // namespace camrig::stream
