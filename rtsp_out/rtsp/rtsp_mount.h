#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <gst/rtsp-server/rtsp-server.h>

#include "core/base/wall_offset.h"
#include "rtsp_out/rtsp/media_feed.h"
#include "rtsp_out/rtsp/rtsp_options.h"
#include "rtsp_out/rtsp/rtsp_output.h"

namespace camrig::rtsp {

/// One mount point of the server, "/NAME", "/NAME/sub" or "/NAME/mjpeg": makes the pipeline (media) for the first
/// client, shares it among all clients, and ends it after the last one.
///
/// A mount never changes: when its camera does, it is replaced by another one. Server thread; what the media's own
/// thread calls is guarded.
class RtspMount {
public:
    /// Everything that defines a mount; when it differs from the present one, the mount is replaced.
    struct Plan {
        std::string path;
        std::string launch;
        stream::CameraStream camera;
        stream::MediaFormat format;
        StreamSettings settings;
        friend bool operator==(const Plan& a, const Plan& b) {
            return a.path == b.path && a.launch == b.launch && a.format == b.format && a.camera.id == b.camera.id &&
                   a.camera.size == b.camera.size && a.camera.rate == b.camera.rate &&
                   a.settings.size == b.settings.size && a.settings.rate == b.settings.rate;
        }
    };
    /// The plan for one of a camera's streams. unsupported: RTP cannot carry pictures of this format and size, or there
    /// is no encoder; the message names what works.
    static Result<Plan> plan(const StreamSettings& stream, const stream::CameraStream& camera,
                             const RtspOptions& options);

    /// `addresses`: the pool of local UDP addresses and multicast groups.
    RtspMount(Plan plan, const RtspOptions& options, GstRTSPMountPoints* mounts,
              GObjectHandle<GstRTSPAddressPool> addresses, WallOffset* wall);
    ~RtspMount();
    RtspMount(const RtspMount&) = delete;
    RtspMount& operator=(const RtspMount&) = delete;

    const Plan& plan() const { return plan_; }
    /// The feeds of its running pipelines; empty while no client is there.
    std::vector<std::shared_ptr<MediaFeed>> feeds() const;
    /// The feed of a media that an RtspMount made; null for others.
    static std::shared_ptr<MediaFeed> feed_of(GstRTSPMedia* media);

private:
    static void on_media(GstRTSPMediaFactory* factory, GstRTSPMedia* media, void* mount);

    const Plan plan_;
    const RtspOptions& options_;
    const GObjectHandle<GstRTSPMountPoints> mounts_;
    WallOffset* const wall_;
    GObjectHandle<GstRTSPMediaFactory> factory_;
    gulong media_signal_ = 0;
    std::vector<std::weak_ptr<MediaFeed>> feeds_;
};

}  // namespace camrig::rtsp
