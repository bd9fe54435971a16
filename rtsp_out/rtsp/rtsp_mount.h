#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <gst/rtsp-server/rtsp-server.h>

#include "rtsp_out/rtsp/media_feed.h"
#include "rtsp_out/rtsp/rtsp_options.h"
#include "rtsp_out/rtsp/rtsp_output.h"

namespace camrig::rtsp {

/// One path of the server, "/NAME", "/NAME/sub" or "/NAME/mjpeg": makes the stream when somebody comes, shares it among
/// all who come, and lets it go when the last one left.
///
/// A mount never changes: when its camera does, it is ended and another one takes its place. Server thread; what the
/// media's own thread calls is guarded.
class RtspMount {
public:
    /// How the mount of this one of the camera's streams is to be. unsupported: the camera's pictures do
    /// not fit the format, or nothing is there to encode them; the message names what works.
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
    static Result<Plan> plan(const StreamSettings& stream, const stream::CameraStream& camera,
                             const RtspOptions& options);

    /// `addresses`: where it may send from by UDP, and the groups it may send to.
    RtspMount(Plan plan, const RtspOptions& options, GstRTSPMountPoints* mounts,
              GObjectHandle<GstRTSPAddressPool> addresses, WallOffset* wall);
    ~RtspMount();
    RtspMount(const RtspMount&) = delete;
    RtspMount& operator=(const RtspMount&) = delete;

    const Plan& plan() const { return plan_; }
    /// The stream while there is one.
    std::vector<std::shared_ptr<MediaFeed>> feeds() const;
    /// The feed of a media that a mount made, or null.
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
