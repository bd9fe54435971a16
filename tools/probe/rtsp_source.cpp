#include <algorithm>
#include <mutex>
#include <vector>

#include <gst/app/gstappsink.h>
#include <gst/gst.h>
#include <gst/video/video.h>

#include "core/base/clock.h"
#include "tools/probe/gray.h"
#include "tools/probe/source.h"

// RTSP by GStreamer, as a viewer would: rtspsrc ! decodebin. RTP stamps tell distances only; with sender reports the
// instant's wall clock comes along (reference time of the buffer), and with it the latency.
namespace camrig::probe {
namespace {

constexpr guint max_waiting_pictures = 4;
constexpr TimeNs ntp_to_unix_ns = TimeNs{2'208'988'800} * ns_per_s;

template <typename T>
struct GstUnref {
    void operator()(T* object) const { gst_object_unref(object); }
};
template <typename T>
using GstRef = std::unique_ptr<T, GstUnref<T>>;

void start_gstreamer() {
    static std::once_flag once;
    std::call_once(once, [] { gst_init(nullptr, nullptr); });
}

class RtspSource final : public Source {
public:
    explicit RtspSource(std::string url) : url_(std::move(url)) {}
    ~RtspSource() override {
        if (pipeline_) gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
    }

    Result<void> begin(const SourceOptions& options) {
        GError* problem = nullptr;
        // buffer-mode=none (0): stamps are what the RTP packets say, not what a jitter buffer makes of them.
        GstElement* made = gst_parse_launch(
            "rtspsrc name=in latency=0 buffer-mode=0 ! decodebin name=decoder ! videoconvert ! "
            "video/x-raw,format=GRAY8 ! appsink name=out sync=false",
            &problem);
        if (problem != nullptr) {
            const std::string why = problem->message;
            g_error_free(problem);
            if (made != nullptr) gst_object_unref(made);
            return error(ErrorKind::unsupported, "GStreamer lacks a part: " + why);
        }
        pipeline_.reset(made);
        GstRef<GstElement> in(gst_bin_get_by_name(GST_BIN(made), "in"));
        g_object_set(in.get(), "location", url_.c_str(), nullptr);
        gst_util_set_object_arg(G_OBJECT(in.get()), "protocols", options.rtsp_over_udp ? "udp" : "tcp");
        // Since GStreamer 1.22.
        if (g_object_class_find_property(G_OBJECT_GET_CLASS(in.get()), "add-reference-timestamp-meta"))
            g_object_set(in.get(), "add-reference-timestamp-meta", TRUE, nullptr);
        sink_.reset(gst_bin_get_by_name(GST_BIN(made), "out"));
        gst_app_sink_set_max_buffers(GST_APP_SINK(sink_.get()), max_waiting_pictures);
        bus_.reset(gst_element_get_bus(made));
        gst_element_set_state(made, GST_STATE_PLAYING);
        return {};
    }

    std::string_view kind() const override { return "rtsp"; }
    std::string format() const override { return format_; }
    bool stamps_are_monotonic() const override { return has_wall_clock_; }

    Result<std::optional<ProbedPicture>> next(TimeNs until_ns) override {
        for (;;) {
            const TimeNs slice = std::clamp<TimeNs>(until_ns - monotonic_now_ns(), 0, 50 * ns_per_ms);
            GstSample* sample = gst_app_sink_try_pull_sample(GST_APP_SINK(sink_.get()), static_cast<guint64>(slice));
            if (sample != nullptr) {
                auto picture = picture_of(sample);
                gst_sample_unref(sample);
                return picture;
            }
            if (auto fine = check_bus(); !fine) return std::unexpected(fine.error());
            if (monotonic_now_ns() >= until_ns) return std::nullopt;
        }
    }

private:
    Result<void> check_bus() {
        GstMessage* message =
            gst_bus_pop_filtered(bus_.get(), static_cast<GstMessageType>(GST_MESSAGE_ERROR | GST_MESSAGE_EOS));
        if (message == nullptr) return {};
        std::string why = "the server ended the stream";
        if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) {
            GError* problem = nullptr;
            gst_message_parse_error(message, &problem, nullptr);
            why = problem->message;
            g_error_free(problem);
        }
        gst_message_unref(message);
        return error(ErrorKind::unavailable, why);
    }

    std::optional<ProbedPicture> picture_of(GstSample* sample) {
        ProbedPicture picture;
        picture.arrival_ns = monotonic_now_ns();
        GstBuffer* buffer = gst_sample_get_buffer(sample);
        picture.damaged = GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_CORRUPTED);
        if (GST_BUFFER_PTS_IS_VALID(buffer)) picture.stamp_ns = static_cast<TimeNs>(GST_BUFFER_PTS(buffer));
        if (const auto instant = wall_clock_of(buffer)) picture.stamp_ns = *instant;
        if (format_.empty()) format_ = codec_name();

        GstVideoInfo info;
        GstVideoFrame frame;
        if (!gst_video_info_from_caps(&info, gst_sample_get_caps(sample)) ||
            !gst_video_frame_map(&frame, &info, buffer, GST_MAP_READ))
            return picture;
        picture.size = {GST_VIDEO_FRAME_WIDTH(&frame), GST_VIDEO_FRAME_HEIGHT(&frame)};
        const auto row = static_cast<std::size_t>(GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0));
        const auto* bytes = static_cast<const std::byte*>(GST_VIDEO_FRAME_PLANE_DATA(&frame, 0));
        const std::size_t length = row * static_cast<std::size_t>(picture.size.height);
        if (gray_from_raw(v4l2_grey, {bytes, length}, picture.size, row, gray_)) picture.gray = gray_;
        gst_video_frame_unmap(&frame);
        return picture;
    }

    /// CLOCK_MONOTONIC of the instant the sender gave this picture, once its sender reports tell.
    std::optional<TimeNs> wall_clock_of(GstBuffer* buffer) {
        const GstReferenceTimestampMeta* meta = gst_buffer_get_reference_timestamp_meta(buffer, nullptr);
        if (meta == nullptr || !gst_structure_has_name(gst_caps_get_structure(meta->reference, 0), "timestamp/x-ntp"))
            return std::nullopt;
        has_wall_clock_ = true;
        const TimeNs unix_ns = static_cast<TimeNs>(meta->timestamp) - ntp_to_unix_ns;
        return unix_ns - (realtime_now_ns() - monotonic_now_ns());
    }

    std::string codec_name() const {
        GstRef<GstElement> decoder(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "decoder"));
        GstRef<GstPad> pad(gst_element_get_static_pad(decoder.get(), "sink"));
        GstCaps* caps = pad ? gst_pad_get_current_caps(pad.get()) : nullptr;
        if (caps == nullptr) return "RTP";
        const gchar* name = gst_structure_get_string(gst_caps_get_structure(caps, 0), "encoding-name");
        const std::string text = name != nullptr ? name : "RTP";
        gst_caps_unref(caps);
        return text;
    }

    static constexpr std::uint32_t v4l2_grey = 0x59455247;  // V4L2_PIX_FMT_GREY

    const std::string url_;
    GstRef<GstElement> pipeline_, sink_;
    GstRef<GstBus> bus_;
    std::string format_;
    bool has_wall_clock_ = false;
    std::vector<std::byte> gray_;
};

}  // namespace

Result<std::unique_ptr<Source>> open_rtsp_source(const std::string& url, const SourceOptions& options) {
    start_gstreamer();
    auto source = std::make_unique<RtspSource>(url);
    if (auto begun = source->begin(options); !begun) return std::unexpected(begun.error());
    return source;
}

}  // namespace camrig::probe
