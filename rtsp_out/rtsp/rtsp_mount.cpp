#include "rtsp_out/rtsp/rtsp_mount.h"

#include "core/base/clock.h"
#include "core/base/tcp_listener.h"
#include "rtsp_out/rtsp/media_pipeline.h"

namespace camrig::rtsp {
namespace {

constexpr const char* feed_key = "camrig-feed";

}  // namespace

Result<RtspMount::Plan> RtspMount::plan(const StreamSettings& stream, const stream::CameraStream& camera,
                                        const RtspOptions& options) {
    Plan plan{"/" + camera.name + std::string(path_ending(stream.options)), "", camera, {}, stream};
    if (stream.size != camera.size) plan.format.size = stream.size;
    if (stream.options.codec != RtspCodec::mjpeg) {
        const auto encoder = choose_video_encoder(options.h264_elements, stream);
        if (!encoder) return std::unexpected(encoder.error());
        plan.format.pixels = encoder->pixels;
        const char* const payloader = stream.options.codec == RtspCodec::h265 ? "rtph265pay" : "rtph264pay";
        plan.launch = "( appsrc name=src ! " + encoder->launch + " ! " + payloader +
                      " name=pay0 pt=96 config-interval=-1 aggregate-mode=zero-latency )";
        return plan;
    }
    if (!can_be_carried(stream)) {
        return error(ErrorKind::unsupported, "RTP carries JPEG of sizes in multiples of 8 up to 2040, not " +
                                                 stream.size.to_string() + "; use H.264 at /" + camera.name +
                                                 " or MJPEG over HTTP at /cameras/" + camera.name + "/stream.mjpg");
    }
    plan.format.codec = codec::Codec::jpeg;
    plan.format.quality = stream.options.quality;
    plan.launch = "( appsrc name=src ! rtpjpegpay name=pay0 pt=26 )";
    return plan;
}

RtspMount::RtspMount(Plan plan, const RtspOptions& options, GstRTSPMountPoints* mounts,
                     GObjectHandle<GstRTSPAddressPool> addresses, WallOffset* wall)
    : plan_(std::move(plan)),
      options_(options),
      mounts_(GST_RTSP_MOUNT_POINTS(g_object_ref(mounts))),
      wall_(wall),
      factory_(gst_rtsp_media_factory_new()) {
    GstRTSPMediaFactory* factory = factory_.get();
    gst_rtsp_media_factory_set_launch(factory, plan_.launch.c_str());
    gst_rtsp_media_factory_set_shared(factory, TRUE);
    gst_rtsp_media_factory_set_latency(factory, 0);
    int protocols = GST_RTSP_LOWER_TRANS_UDP | GST_RTSP_LOWER_TRANS_TCP;
    if (!is_loopback_address(options.host)) protocols |= GST_RTSP_LOWER_TRANS_UDP_MCAST;
    gst_rtsp_media_factory_set_address_pool(factory, addresses.get());
    gst_rtsp_media_factory_set_protocols(factory, static_cast<GstRTSPLowerTrans>(protocols));
    media_signal_ = g_signal_connect(factory, "media-configure", G_CALLBACK(on_media), this);
    gst_rtsp_mount_points_add_factory(mounts_.get(), plan_.path.c_str(), GST_RTSP_MEDIA_FACTORY(g_object_ref(factory)));
}

RtspMount::~RtspMount() {
    gst_rtsp_mount_points_remove_factory(mounts_.get(), plan_.path.c_str());
    g_signal_handler_disconnect(factory_.get(), media_signal_);
}

void RtspMount::on_media(GstRTSPMediaFactory*, GstRTSPMedia* media, void* mount) {
    auto* const self = static_cast<RtspMount*>(mount);
    const GObjectHandle<GstElement> bin(gst_rtsp_media_get_element(media));
    const GObjectHandle<GstObject> pipeline(gst_object_get_parent(GST_OBJECT(bin.get())));
    CHECK(pipeline != nullptr);
    const RtpTimeline timeline(monotonic_now_ns(), g_random_int(), self->wall_->current());
    const Plan& plan = self->plan_;
    const bool is_h265 = plan.settings.options.codec == RtspCodec::h265;
    auto feed = MediaFeed::create({.bus = self->options_.bus,
                                   .fetcher = self->options_.fetcher,
                                   .camera = plan.camera,
                                   .format = plan.format,
                                   .size = plan.settings.size,
                                   .rate = plan.settings.rate,
                                   .codec = is_h265 ? NalCodec::h265 : NalCodec::h264,
                                   .path = plan.path,
                                   .timeline = timeline},
                                  bin.get());
    const std::weak_ptr<MediaFeed> weak = feed;
    const auto ask = [weak](bool (MediaFeed::*question)(), bool without_feed) {
        const auto alive = weak.lock();
        return alive ? (alive.get()->*question)() : without_feed;
    };
    const auto sender_time = [weak, timeline](TimeNs now_ns) {
        const auto alive = weak.lock();
        return alive ? alive->sender_time(now_ns) : timeline.sender_time(now_ns);
    };
    set_up_media_pipeline(GST_PIPELINE(pipeline.get()), timeline.base_ns(),
                          {[ask] { return ask(&MediaFeed::tcp_readers_take, true); },
                           [ask] { return ask(&MediaFeed::is_lockstep, false); }, sender_time});
    std::erase_if(self->feeds_, [](const auto& old) { return old.expired(); });
    self->feeds_.push_back(feed);

    using Owner = std::shared_ptr<MediaFeed>;
    const auto stop = +[](GstRTSPMedia* done, void*) {
        if (const auto stopping = feed_of(done)) stopping->stop();
    };
    g_signal_connect(media, "unprepared", G_CALLBACK(stop), nullptr);
    g_object_set_data_full(G_OBJECT(media), feed_key, new Owner(std::move(feed)),
                           [](void* owner) { delete static_cast<Owner*>(owner); });
}

std::shared_ptr<MediaFeed> RtspMount::feed_of(GstRTSPMedia* media) {
    auto* const owner = media ? g_object_get_data(G_OBJECT(media), feed_key) : nullptr;
    return owner ? *static_cast<std::shared_ptr<MediaFeed>*>(owner) : nullptr;
}

std::vector<std::shared_ptr<MediaFeed>> RtspMount::feeds() const {
    std::vector<std::shared_ptr<MediaFeed>> alive;
    for (const auto& weak : feeds_)
        if (auto feed = weak.lock()) alive.push_back(std::move(feed));
    return alive;
}

}  // namespace camrig::rtsp
