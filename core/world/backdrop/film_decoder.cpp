#include "core/world/backdrop/film_decoder.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>
#include <optional>
#include <string>

#include "core/world/backdrop/libav_library.h"

namespace camrig::world {
namespace libav {
namespace {

constexpr int max_side = 8192;
constexpr std::size_t max_pictures = 1'000'000;
/// Names of libav's demuxers. Others open what a text in the file names.
constexpr const char* formats = "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi,mjpeg,mpegts,ogg,flv,nut";

/// Once a decoder was made.
const LibavLibrary& av() {
    static const LibavLibrary* const library = LibavLibrary::open().value();
    return *library;
}

template <auto function>
struct FreedBy {
    template <typename T>
    void operator()(T* one) const {
        (av().*function)(&one);
    }
};
using Format = std::unique_ptr<AVFormatContext, FreedBy<&LibavLibrary::avformat_close_input>>;
using Codec = std::unique_ptr<AVCodecContext, FreedBy<&LibavLibrary::avcodec_free_context>>;
using Packet = std::unique_ptr<AVPacket, FreedBy<&LibavLibrary::av_packet_free>>;
using Frame = std::unique_ptr<AVFrame, FreedBy<&LibavLibrary::av_frame_free>>;
struct FreeScaler {
    void operator()(SwsContext* one) const { av().sws_freeContext(one); }
};
using Scaler = std::unique_ptr<SwsContext, FreeScaler>;

std::unexpected<Error> no_film(std::string why, ErrorKind kind = ErrorKind::invalid_argument) {
    return std::unexpected(Error{kind, std::move(why)});
}

std::string words_of(int error) {
    char text[AV_ERROR_MAX_STRING_SIZE] = "";
    av().av_strerror(error, text, sizeof text);
    return text;
}

Result<Format> opened(const std::filesystem::path& file) {
    static std::once_flag quiet;
    std::call_once(quiet, [] { av().av_log_set_level(AV_LOG_QUIET); });
    AVFormatContext* format = nullptr;
    AVDictionary* options = nullptr;
    av().av_dict_set(&options, "protocol_whitelist", "file", 0);
    av().av_dict_set(&options, "format_whitelist", formats, 0);
    const int error = av().avformat_open_input(&format, ("file:" + file.string()).c_str(), nullptr, &options);
    av().av_dict_free(&options);
    if (error == AVERROR(ENOENT)) return no_film("no such file", ErrorKind::not_found);
    if (error < 0)
        return no_film("no film that is read here (MP4, Matroska, WebM, AVI, MPEG-TS, MJPEG): " + words_of(error));
    return Format(format);
}

/// 0: upright.
int turned_deg(const AVStream& stream) {
#if LIBAVFORMAT_VERSION_INT >= AV_VERSION_INT(60, 15, 100)
    const AVPacketSideData* const side = av().av_packet_side_data_get(
        stream.codecpar->coded_side_data, stream.codecpar->nb_coded_side_data, AV_PKT_DATA_DISPLAYMATRIX);
    const std::uint8_t* const matrix = side != nullptr ? side->data : nullptr;
#else
    const std::uint8_t* const matrix = av().av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, nullptr);
#endif
    if (matrix == nullptr) return 0;
    std::int32_t numbers[9];
    std::memcpy(numbers, matrix, sizeof numbers);
    const double angle = av().av_display_rotation_get(numbers);
    // A mirrored picture has the turn 0 or 180, and a determinant below 0.
    const bool is_mirrored =
        static_cast<double>(numbers[0]) * numbers[4] < static_cast<double>(numbers[1]) * numbers[3];
    return std::isnan(angle) || is_mirrored ? 360 : static_cast<int>(std::lround(-angle));
}

Result<void> check(const AVStream& stream) {
    const AVCodecParameters& of = *stream.codecpar;
    if (of.width < 1 || of.height < 1) return no_film("no film that is read here: it has no pictures");
    if (of.width > max_side || of.height > max_side)
        return no_film("a film of " + std::to_string(of.width) + "x" + std::to_string(of.height) +
                       "; at most 8192x8192 is read");
    if (const int turned = turned_deg(stream); turned != 0)
        return no_film("is stored turned (by " + std::to_string(turned) + " degrees); save it upright",
                       ErrorKind::unsupported);
    const AVRational sides = stream.sample_aspect_ratio.num != 0 ? stream.sample_aspect_ratio : of.sample_aspect_ratio;
    if (sides.num != 0 && sides.num != sides.den)
        return no_film("its pixels are no squares (" + std::to_string(sides.num) + ":" + std::to_string(sides.den) +
                           "); save it with square ones",
                       ErrorKind::unsupported);
    if (of.field_order != AV_FIELD_UNKNOWN && of.field_order != AV_FIELD_PROGRESSIVE)
        return no_film("is interlaced; save it with whole pictures", ErrorKind::unsupported);
    if (of.color_trc == AVCOL_TRC_SMPTE2084 || of.color_trc == AVCOL_TRC_ARIB_STD_B67 ||
        of.color_space == AVCOL_SPC_BT2020_NCL || of.color_space == AVCOL_SPC_BT2020_CL)
        return no_film("has a high dynamic range or the colours of BT.2020; save it with those of BT.709",
                       ErrorKind::unsupported);
    return {};
}

/// The same layout without a range in its name.
AVPixelFormat without_range(AVPixelFormat format) {
    switch (format) {
        case AV_PIX_FMT_YUVJ420P:
            return AV_PIX_FMT_YUV420P;
        case AV_PIX_FMT_YUVJ422P:
            return AV_PIX_FMT_YUV422P;
        case AV_PIX_FMT_YUVJ444P:
            return AV_PIX_FMT_YUV444P;
        case AV_PIX_FMT_YUVJ440P:
            return AV_PIX_FMT_YUV440P;
        default:
            return format;
    }
}

bool is_gray(AVPixelFormat format) {
    return format == AV_PIX_FMT_GRAY8 || format == AV_PIX_FMT_GRAY10 || format == AV_PIX_FMT_GRAY12;
}

/// A row of opaque pixels from those of its colours.
void pack(const std::uint8_t* red, const std::uint8_t* green, const std::uint8_t* blue, int width, std::uint8_t* to) {
    for (int x = 0; x < width; ++x) {
        const std::uint32_t pixel =
            red[x] | std::uint32_t{green[x]} << 8 | std::uint32_t{blue[x]} << 16 | std::uint32_t{0xFF} << 24;
        std::memcpy(to + 4 * static_cast<std::ptrdiff_t>(x), &pixel, sizeof pixel);
    }
}

class LibavDecoder : public FilmDecoder {
public:
    static Result<std::unique_ptr<FilmDecoder>> create(const std::filesystem::path& file) {
        if (auto library = LibavLibrary::open(); !library) return std::unexpected(library.error());
        std::unique_ptr<LibavDecoder> made(new LibavDecoder(file));
        if (auto good = made->begin(); !good) return std::unexpected(good.error());
        return made;
    }
    Result<FilmIndex> index() override;
    Result<Image> picture(const FilmIndex& index, std::size_t number) override;

private:
    explicit LibavDecoder(std::filesystem::path file)
        : file_(std::move(file)),
          packet_(av().av_packet_alloc()),
          frame_(av().av_frame_alloc()),
          planes_(av().av_frame_alloc()) {}
    Result<void> begin();
    AVStream& stream() const { return *format_->streams[stream_]; }
    /// Decodes the next picture into frame_; false: there is none.
    bool next();
    Result<void> seek(std::int64_t time);
    /// Until the picture of that time; false: there is none.
    bool find(std::int64_t time);
    Result<Image> converted(ImageSize size);

    std::filesystem::path file_;
    Format format_;
    Codec codec_;
    int stream_ = 0;
    Packet packet_;
    Frame frame_, planes_;
    Scaler scaler_;
    std::optional<std::int64_t> last_time_;  ///< of frame_; nullopt: where the file stands is not known
    bool is_at_end_ = false;
};

Result<void> LibavDecoder::begin() {
    auto format = opened(file_);
    if (!format) return std::unexpected(format.error());
    format_ = std::move(*format);
    if (const int error = av().avformat_find_stream_info(format_.get(), nullptr); error < 0)
        return no_film("cannot be read: " + words_of(error));
    const AVCodec* decoder = nullptr;
    stream_ = av().av_find_best_stream(format_.get(), AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0);
    if (stream_ < 0 || decoder == nullptr) return no_film("has no pictures that can be decoded");
    for (unsigned i = 0; i < format_->nb_streams; ++i)
        if (static_cast<int>(i) != stream_) format_->streams[i]->discard = AVDISCARD_ALL;
    if (auto good = check(stream()); !good) return good;
    codec_.reset(av().avcodec_alloc_context3(decoder));
    if (codec_ == nullptr || av().avcodec_parameters_to_context(codec_.get(), stream().codecpar) < 0)
        return no_film("no memory for its decoder", ErrorKind::resource_exhausted);
    codec_->thread_count = 1;
    codec_->pkt_timebase = stream().time_base;
    codec_->max_pixels = std::int64_t{max_side} * max_side;
    if (const int error = av().avcodec_open2(codec_.get(), decoder, nullptr); error < 0)
        return no_film("its decoder: " + words_of(error));
    last_time_.reset();
    is_at_end_ = false;
    return {};
}

Result<FilmIndex> LibavDecoder::index() {
    FilmIndex made{
        .size = {stream().codecpar->width, stream().codecpar->height}, .rate = {}, .times = {}, .starts = {}};
    while (av().av_read_frame(format_.get(), packet_.get()) >= 0) {
        const bool is_shown = packet_->stream_index == stream_ && (packet_->flags & AV_PKT_FLAG_DISCARD) == 0;
        const std::int64_t time = packet_->pts != AV_NOPTS_VALUE ? packet_->pts : packet_->dts;
        const bool is_start = (packet_->flags & AV_PKT_FLAG_KEY) != 0;
        av().av_packet_unref(packet_.get());
        if (!is_shown) continue;
        if (time == AV_NOPTS_VALUE) return no_film("its pictures have no times; save it as MP4 or Matroska");
        if (made.times.size() == max_pictures) return no_film("has more than a million pictures");
        made.times.push_back(time);
        if (is_start) made.starts.push_back(time);
    }
    std::ranges::sort(made.times);
    std::ranges::sort(made.starts);
    if (made.times.empty()) return no_film("has no pictures");
    if (std::ranges::adjacent_find(made.times) != made.times.end())
        return no_film("has two pictures of one time; save it anew");
    const AVRational given = stream().avg_frame_rate.num > 0 ? stream().avg_frame_rate : stream().r_frame_rate;
    const auto rate = Rate::create(given.num, given.den);
    if (!rate) return no_film("says no rate of its pictures within 1/10 and 1000 a second; save it with one");
    made.rate = *rate;
    return made;
}

bool LibavDecoder::next() {
    for (;;) {
        const int got = av().avcodec_receive_frame(codec_.get(), frame_.get());
        if (got >= 0) {
            last_time_ = frame_->best_effort_timestamp;
            return true;
        }
        if (got == AVERROR_EOF || is_at_end_) return false;
        if (const int read = av().av_read_frame(format_.get(), packet_.get()); read < 0) {
            is_at_end_ = true;
            av().avcodec_send_packet(codec_.get(), nullptr);
            continue;
        }
        // What is damaged is left out: the pictures that need it are not found.
        if (packet_->stream_index == stream_) av().avcodec_send_packet(codec_.get(), packet_.get());
        av().av_packet_unref(packet_.get());
    }
}

Result<void> LibavDecoder::seek(std::int64_t time) {
    last_time_.reset();
    is_at_end_ = false;
    av().avcodec_flush_buffers(codec_.get());
    if (av().av_seek_frame(format_.get(), stream_, time, AVSEEK_FLAG_BACKWARD) >= 0) return {};
    return begin();
}

bool LibavDecoder::find(std::int64_t time) {
    while (next()) {
        if (*last_time_ == time) return true;
        if (*last_time_ > time) return false;
    }
    return false;
}

Result<Image> LibavDecoder::picture(const FilmIndex& index, std::size_t number) {
    const std::int64_t time = index.times[number];
    const auto after = std::ranges::upper_bound(index.starts, time);
    const std::int64_t start = after == index.starts.begin() ? index.times.front() : *(after - 1);
    const bool is_ahead = last_time_ && *last_time_ < time &&
                          (start <= *last_time_ || (number > 0 && *last_time_ == index.times[number - 1]));
    if (!is_ahead || !find(time)) {
        if (auto good = seek(start); !good) return std::unexpected(good.error());
        if (!find(time)) {
            // Not all files can be sought in.
            if (auto good = begin(); !good) return std::unexpected(good.error());
            if (!find(time)) return no_film("picture " + std::to_string(number) + " cannot be decoded");
        }
    }
    return converted(index.size);
}

Result<Image> LibavDecoder::converted(ImageSize size) {
    if (frame_->width != size.width || frame_->height != size.height) return no_film("its pictures change their size");
    const auto format = static_cast<AVPixelFormat>(frame_->format);
    const AVPixelFormat plain = without_range(format);
    // To planes of colours: of libswscale 6 packed ones are off by up to 90 codes at edges of chroma, and take four
    // times as long. Gray has no chroma, and keeps its range on the way to packed pixels alone.
    const AVPixelFormat target = is_gray(plain) ? AV_PIX_FMT_RGBA : AV_PIX_FMT_GBRP;
    constexpr int flags = SWS_BILINEAR | SWS_FULL_CHR_H_INT | SWS_ACCURATE_RND | SWS_BITEXACT;
    scaler_.reset(av().sws_getCachedContext(scaler_.release(), size.width, size.height, plain, size.width, size.height,
                                            target, flags, nullptr, nullptr, nullptr));
    if (scaler_ == nullptr) return no_film("its pixels are of a format that cannot be converted");
    const bool is_full = plain != format || frame_->color_range == AVCOL_RANGE_JPEG;
    const bool is_709 = frame_->colorspace == AVCOL_SPC_BT709 ||
                        (frame_->colorspace == AVCOL_SPC_UNSPECIFIED && plain == format && size.height >= 720);
    av().sws_setColorspaceDetails(scaler_.get(), av().sws_getCoefficients(is_709 ? SWS_CS_ITU709 : SWS_CS_ITU601),
                                  is_full, av().sws_getCoefficients(SWS_CS_DEFAULT), 1, 0, 1 << 16, 1 << 16);
    // libswscale writes whole groups of pixels: into rows with room for them.
    if (planes_->format != target) {
        planes_.reset(av().av_frame_alloc());
        if (planes_ == nullptr) return no_film("no memory", ErrorKind::resource_exhausted);
        planes_->format = target;
        planes_->width = size.width;
        planes_->height = size.height;
        if (av().av_frame_get_buffer(planes_.get(), 64) < 0) {
            planes_->format = AV_PIX_FMT_NONE;
            return no_film("no memory", ErrorKind::resource_exhausted);
        }
    }
    if (av().sws_scale(scaler_.get(), frame_->data, frame_->linesize, 0, size.height, planes_->data,
                       planes_->linesize) != size.height)
        return no_film("a picture cannot be converted");
    Image image{.size = size, .rgba = std::vector<std::uint8_t>(static_cast<std::size_t>(size.pixels()) * 4)};
    const auto row = [&](int plane, int y) {
        return planes_->data[plane] + static_cast<std::ptrdiff_t>(y) * planes_->linesize[plane];
    };
    const std::size_t bytes_of_row = std::size_t{4} * static_cast<std::size_t>(size.width);
    for (int y = 0; y < size.height; ++y) {
        std::uint8_t* const to = image.rgba.data() + bytes_of_row * static_cast<std::size_t>(y);
        if (target == AV_PIX_FMT_RGBA) {
            std::memcpy(to, row(0, y), bytes_of_row);
        } else {
            pack(row(2, y), row(0, y), row(1, y), size.width, to);
        }
    }
    for (std::size_t i = 3; target == AV_PIX_FMT_RGBA && i < image.rgba.size(); i += 4) image.rgba[i] = 255;
    return image;
}

}  // namespace
}  // namespace libav

Result<std::unique_ptr<FilmDecoder>> FilmDecoder::open(const std::filesystem::path& file) {
    return libav::LibavDecoder::create(file);
}

}  // namespace camrig::world
