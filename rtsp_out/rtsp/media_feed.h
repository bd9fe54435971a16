#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>

#include <gst/rtsp-server/rtsp-server.h>

#include "core/stream/frame_bus.h"
#include "rtsp_out/rtsp/packet_faults.h"
#include "rtsp_out/rtsp/picture_stamps.h"
#include "rtsp_out/rtsp/pictures_on_way.h"
#include "rtsp_out/rtsp/stream_times.h"
#include "rtsp_out/rtsp/tcp_readers.h"

namespace camrig::rtsp {

/// Feeds a camera's pictures into the pipeline of one RTSP stream, from the moment the pipeline runs until it ends.
///
/// The pipeline begins with an appsrc named "src" that keeps the newest two pictures and ends with a payloader named
/// "pay0"; between them "enc" encodes, or nothing when the pictures are JPEG already. PictureStamps says what each is
/// stamped with, and when the last one is sent again.
///
/// A picture holds its latch (lockstep) until the last byte of it has been written to the last client: the hold lives
/// as long as the memory of the encoded picture, which every RTP packet refers to.
///
/// Threads: Sink calls come from the output's thread; the pipeline's streaming thread calls in through the appsrc and a
/// probe; all else is the server's.
class MediaFeed final : public stream::Sink, public std::enable_shared_from_this<MediaFeed> {
public:
    struct Options {
        stream::FrameBus* bus = nullptr;
        stream::FrameFetcher* fetcher = nullptr;
        stream::CameraStream camera;
        stream::MediaFormat format;
        ImageSize size;                   ///< of the stream, as `format` has it
        Rate rate;                        ///< at most the camera's
        NalCodec codec = NalCodec::h264;  ///< unless the pictures are JPEG
        std::string path;                 ///< for messages and statistics
        RtpTimeline timeline;
    };

    /// `bin` is the element of the media (see above); it must not run yet.
    static std::shared_ptr<MediaFeed> create(Options options, GstElement* bin);
    ~MediaFeed() override;

    const RtpTimeline& timeline() const { return options_.timeline; }
    /// What a sender report that goes now says: the timeline, as the camera's clock has it. Any thread.
    RtpTimeline::SenderTime sender_time(TimeNs now_ns);
    const std::string& path() const { return options_.path; }

    /// The codec of its NAL units; nullopt: the stream is JPEG.
    std::optional<NalCodec> nal_codec() const;

    /// A client has begun to play (RTSP PLAY): requests a key frame, sends the last picture again if none is due soon,
    /// and makes pictures hold their latch from here on.
    void client_plays(const GstRTSPClient* client);
    /// Adds the connection of a client that plays over TCP.
    void add_tcp_reader(GSocket* socket) { tcp_readers_.add(socket); }
    /// It has paused, or does not want the stream any more (RTSP PAUSE, TEARDOWN), or is gone: nothing waits for it.
    /// `socket`: its connection, if that is there.
    void client_rests(const GstRTSPClient* client, GSocket* socket);
    /// Whether packets may be sent to the TCP clients. Not while the socket of every one of them is full: that would
    /// block the pipeline, and its UDP clients too. In lockstep always: there the step waits. Streaming thread.
    bool tcp_readers_take();
    /// Pictures come with latches. Any thread.
    bool is_lockstep();
    /// Sends the last picture again if that is due (PictureStamps). To be called ten times a second.
    void repeat_if_idle(TimeNs now_ns);
    /// Ends the stream for its clients (end of stream, RTCP BYE): the camera was deleted or changed.
    void end();
    /// Whether end() is so long ago that clients have received it. Any thread.
    bool has_ended(TimeNs now_ns) const;
    /// A fault wants the clients' connections reset, without an orderly end. Any thread.
    bool is_reset() const { return is_reset_; }
    /// The pipeline is being shut down: ends the subscription, and touches the pipeline no more.
    void stop();

    Result<void> open(const stream::StreamInfo& info) override;
    Result<void> write(const stream::MediaUnit& unit) override;
    void close() noexcept override;
    void hold_back() override;
    void reset() override { is_reset_ = true; }

private:
    MediaFeed(Options options, GstElement* bin);
    void start();
    void first_picture(Result<stream::MediaUnit> unit);
    void keep(const stream::MediaUnit& unit);
    void push(const stream::MediaUnit& unit, TimeNs stamp_ns, std::shared_ptr<PendingPicture> pending);
    /// Changes the stream's SSRC, if a fault says so at this picture. With the mutex held.
    void follow_ssrc();

    static void on_need_data(GstElement* source, unsigned bytes, void* feed);
    static GstPadProbeReturn on_packets(GstPad* pad, GstPadProbeInfo* info, void* feed);
    static GstPadProbeReturn on_encoded(GstPad* pad, GstPadProbeInfo* info, void* feed);

    const Options options_;
    ImageSize shown_;  ///< what of the picture is sent: H.264 has even sizes only
    GObjectHandle<GstElement> source_;
    GObjectHandle<GstElement> encoder_;  ///< null for JPEG
    GObjectHandle<GstElement> payloader_;

    std::atomic<TimeNs> ended_ns_{max_time_ns};
    std::atomic<bool> is_reset_{false};

    PacketFaults packet_faults_;  ///< streaming thread
    PicturesOnWay on_way_;
    TcpReaders tcp_readers_;

    std::mutex mutex_;  ///< guards what follows
    bool started_ = false;
    bool stopped_ = false;
    std::set<const GstRTSPClient*> players_;
    bool lockstep_ = false;
    bool is_held_back_ = false;                         ///< a fault keeps pictures from it
    std::shared_ptr<const fault::FrameFaults> faults_;  ///< of the newest picture
    std::uint64_t ssrc_epoch_ = 0;                      ///< of it
    std::shared_ptr<stream::ReaderStats> stats_;
    std::optional<stream::MediaUnit> last_;  ///< without its latch; there once a stamp was given
    PictureStamps stamps_{options_.timeline.base_ns(), options_.rate};
    StreamTimes times_{options_.timeline};

    std::mutex subscription_mutex_;
    std::optional<stream::Subscription> subscription_;
};

}  // namespace camrig::rtsp
