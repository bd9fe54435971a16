#include "rtsp_out/rtsp/video_encoder.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include <gst/gst.h>

namespace camrig::rtsp {
namespace {

constexpr const char* h265_element = "x265enc";
/// Requests for key frames that come closer together are answered by one.
constexpr int min_key_request_ms = 500;
/// More slices than this cost quality and gain no latency worth it.
constexpr std::int64_t pixels_per_thread = 1'000'000;
/// How much the rate may swing, as x264enc has it (vbv-buf-capacity).
constexpr double rate_buffer_s = 0.6;

bool is_installed(const std::string& element) {
    GstElementFactory* factory = gst_element_factory_find(element.c_str());
    if (factory) gst_object_unref(factory);
    return factory != nullptr;
}

std::string key_interval_frames(const StreamSettings& stream) {
    return std::to_string(
        std::max(1, static_cast<int>(std::lround(stream.options.key_interval_s * stream.rate.hertz()))));
}

std::string encoder_threads(const StreamSettings& stream) {
    const auto cores = static_cast<std::int64_t>(std::max(1u, std::thread::hardware_concurrency()));
    return std::to_string(std::min(cores, 1 + stream.size.pixels() / pixels_per_thread));
}

std::string with_caps(std::string element, const RtspOutput& options) {
    const std::string profile = options.profile == "baseline" ? "constrained-baseline" : options.profile;
    return std::move(element) + " ! video/x-h264,stream-format=byte-stream,alignment=au,profile=" + profile;
}

bool is_fast(const RtspOutput& options) {
    return options.preset.ends_with("fast") && options.preset != "fast" && options.preset != "faster";
}

VideoEncoder x264(const StreamSettings& stream, const std::string& common) {
    return {"x264enc",
            with_caps("x264enc name=enc tune=zerolatency speed-preset=" + stream.options.preset + " key-int-max=" +
                          key_interval_frames(stream) + " threads=" + encoder_threads(stream) + common,
                      stream.options),
            frame::PixelFormat::i420};
}

// x265enc of GStreamer 1.22 has few properties; the rest goes through its option string. x265's own names of the
// colours that media_feed.cpp tells: primaries of BT.709, transfer of sRGB, matrix of BT.601, limited range. Chroma in
// the middle of four pixels is type 1 (H.265, E.3.1). An open GOP begins with a picture that decoders cannot begin with
// everywhere.
VideoEncoder x265(const StreamSettings& stream, const std::string& common) {
    const std::string buffer = std::to_string(static_cast<int>(std::lround(stream.bitrate_kbps * rate_buffer_s)));
    return {h265_element,
            "x265enc name=enc tune=zerolatency log-level=none speed-preset=" + stream.options.preset + " key-int-max=" +
                key_interval_frames(stream) + common + " option-string=\"pools=" + encoder_threads(stream) +
                ":frame-threads=1:no-open-gop=1:repeat-headers=1:info=0:vbv-maxrate=" +
                std::to_string(stream.bitrate_kbps) + ":vbv-bufsize=" + buffer +
                ":colorprim=bt709:transfer=iec61966-2-1:colormatrix=smpte170m:range=limited:chromaloc=1\""
                " ! video/x-h265,stream-format=byte-stream,alignment=au,profile=main",
            frame::PixelFormat::i420};
}

VideoEncoder openh264(const StreamSettings& stream) {
    return {"openh264enc",
            with_caps("openh264enc name=enc usage-type=camera rate-control=bitrate bitrate=" +
                          std::to_string(stream.bitrate_kbps * 1000) + " gop-size=" + key_interval_frames(stream) +
                          " complexity=" + (is_fast(stream.options) ? "low" : "medium") +
                          " multi-thread=" + encoder_threads(stream) +
                          " min-force-key-unit-interval=" + std::to_string(min_key_request_ms * 1'000'000),
                      stream.options),
            frame::PixelFormat::i420};
}

// The two hardware encoders are written from their documentation (GStreamer 1.22) and were not run: no machine with
// one was at hand.
VideoEncoder nvidia(const StreamSettings& stream, const std::string& common) {
    return {"nvh264enc",
            with_caps("nvh264enc name=enc zerolatency=true repeat-sequence-header=true bframes=0 rc-mode=cbr preset=" +
                          std::string(is_fast(stream.options) ? "low-latency-hp" : "low-latency-hq") +
                          " gop-size=" + key_interval_frames(stream) + common,
                      stream.options),
            frame::PixelFormat::nv12};
}

VideoEncoder va_api(const StreamSettings& stream, const std::string& common) {
    return {"vah264enc",
            with_caps("vah264enc name=enc b-frames=0 rate-control=cbr target-usage=" +
                          std::string(is_fast(stream.options) ? "7" : "4") +
                          " key-int-max=" + key_interval_frames(stream) + common,
                      stream.options),
            frame::PixelFormat::nv12};
}

}  // namespace

bool has_h265_encoder() {
    return is_installed(h265_element);
}

Result<VideoEncoder> choose_video_encoder(const std::vector<std::string>& elements, const StreamSettings& stream) {
    const std::string common = " bitrate=" + std::to_string(stream.bitrate_kbps) +
                               " min-force-key-unit-interval=" + std::to_string(min_key_request_ms * 1'000'000);
    if (stream.options.codec == RtspCodec::h265) {
        if (has_h265_encoder()) return x265(stream, common);
        return error(ErrorKind::unsupported,
                     std::string("rtsp: no H.265 encoder; ") + h265_element +
                         " is not installed (Debian: gstreamer1.0-plugins-bad); use codec h264");
    }
    std::string tried;
    for (const std::string& element : elements) {
        tried += (tried.empty() ? "" : ", ") + element;
        if (!is_installed(element)) continue;
        if (element == "x264enc") return x264(stream, common);
        if (element == "openh264enc") return openh264(stream);
        if (element == "nvh264enc") return nvidia(stream, common);
        if (element == "vah264enc") return va_api(stream, common);
    }
    return error(ErrorKind::unsupported, "rtsp: no H.264 encoder; none of " + tried +
                                             " is installed (Debian: gstreamer1.0-plugins-ugly has x264enc)");
}

}  // namespace camrig::rtsp
