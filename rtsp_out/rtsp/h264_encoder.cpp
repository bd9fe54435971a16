#include "rtsp_out/rtsp/h264_encoder.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include <gst/gst.h>

namespace camrig::rtsp {
namespace {

constexpr double bits_per_pixel = 0.15;
constexpr int min_default_kbps = 200;
/// Requests for key frames that come closer together are answered by one.
constexpr int min_key_request_ms = 500;
/// More slices than this cost quality and gain no latency worth it.
constexpr std::int64_t pixels_per_thread = 1'000'000;

int key_interval_frames(const RtspOutput& options, const Rate& rate) {
    return std::max(1, static_cast<int>(std::lround(options.key_interval_s * rate.hertz())));
}

int encoder_threads(ImageSize size) {
    const auto cores = static_cast<std::int64_t>(std::max(1u, std::thread::hardware_concurrency()));
    return static_cast<int>(std::min(cores, 1 + size.pixels() / pixels_per_thread));
}

std::string with_caps(std::string element, const RtspOutput& options) {
    const std::string profile = options.profile == "baseline" ? "constrained-baseline" : options.profile;
    return std::move(element) + " ! video/x-h264,stream-format=byte-stream,alignment=au,profile=" + profile;
}

bool is_fast(const RtspOutput& options) {
    return options.preset.ends_with("fast") && options.preset != "fast" && options.preset != "faster";
}

H264Encoder x264(const RtspOutput& options, ImageSize size, const Rate& rate, const std::string& common) {
    return {"x264enc",
            with_caps("x264enc name=enc tune=zerolatency speed-preset=" + options.preset +
                          " key-int-max=" + std::to_string(key_interval_frames(options, rate)) +
                          " threads=" + std::to_string(encoder_threads(size)) + common,
                      options),
            frame::PixelFormat::i420};
}

H264Encoder openh264(const RtspOutput& options, ImageSize size, const Rate& rate, int kbps) {
    return {
        "openh264enc",
        with_caps("openh264enc name=enc usage-type=camera rate-control=bitrate bitrate=" + std::to_string(kbps * 1000) +
                      " gop-size=" + std::to_string(key_interval_frames(options, rate)) + " complexity=" +
                      (is_fast(options) ? "low" : "medium") + " multi-thread=" + std::to_string(encoder_threads(size)) +
                      " min-force-key-unit-interval=" + std::to_string(min_key_request_ms * 1'000'000),
                  options),
        frame::PixelFormat::i420};
}

// The two hardware encoders are written from their documentation (GStreamer 1.22) and were not run: no machine with
// one was at hand.
H264Encoder nvidia(const RtspOutput& options, const Rate& rate, const std::string& common) {
    return {"nvh264enc",
            with_caps("nvh264enc name=enc zerolatency=true repeat-sequence-header=true bframes=0 rc-mode=cbr preset=" +
                          std::string(is_fast(options) ? "low-latency-hp" : "low-latency-hq") +
                          " gop-size=" + std::to_string(key_interval_frames(options, rate)) + common,
                      options),
            frame::PixelFormat::nv12};
}

H264Encoder va_api(const RtspOutput& options, const Rate& rate, const std::string& common) {
    return {"vah264enc",
            with_caps("vah264enc name=enc b-frames=0 rate-control=cbr target-usage=" +
                          std::string(is_fast(options) ? "7" : "4") +
                          " key-int-max=" + std::to_string(key_interval_frames(options, rate)) + common,
                      options),
            frame::PixelFormat::nv12};
}

}  // namespace

int default_bitrate_kbps(ImageSize size, const Rate& rate) {
    const double bits = static_cast<double>(size.pixels()) * rate.hertz() * bits_per_pixel;
    return std::max(min_default_kbps, static_cast<int>(std::lround(bits / 1000)));
}

Result<H264Encoder> choose_h264_encoder(const std::vector<std::string>& elements, const RtspOutput& options,
                                        ImageSize size, const Rate& rate) {
    const int kbps = options.bitrate_kbps.value_or(default_bitrate_kbps(size, rate));
    const std::string common = " bitrate=" + std::to_string(kbps) +
                               " min-force-key-unit-interval=" + std::to_string(min_key_request_ms * 1'000'000);
    std::string tried;
    for (const std::string& element : elements) {
        tried += (tried.empty() ? "" : ", ") + element;
        GstElementFactory* factory = gst_element_factory_find(element.c_str());
        if (!factory) continue;
        gst_object_unref(factory);
        if (element == "x264enc") return x264(options, size, rate, common);
        if (element == "openh264enc") return openh264(options, size, rate, kbps);
        if (element == "nvh264enc") return nvidia(options, rate, common);
        if (element == "vah264enc") return va_api(options, rate, common);
    }
    return error(ErrorKind::unsupported, "rtsp: no H.264 encoder; none of " + tried +
                                             " is installed (Debian: gstreamer1.0-plugins-ugly has x264enc)");
}

}  // namespace camrig::rtsp
