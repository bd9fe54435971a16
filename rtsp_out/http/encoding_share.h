#pragma once

#include <string>
#include <utility>

#include "core/base/result.h"
#include "core/stream/sink.h"
#include "rtsp_out/http/server_state.h"

namespace camrig::http {

/// A stream's claim on one encoding of a camera. Streams of equal format share an encoding; how many different ones a
/// camera has at once is bounded. Server's thread; the state outlives it.
class EncodingShare {
public:
    /// resource_exhausted: this would be one encoding more than HttpLimits::qualities_per_camera.
    static Result<EncodingShare> take(ServerState& state, const std::string& camera,
                                      const stream::MediaFormat& format) {
        auto& formats = state.streams_by_format;
        const auto open_now = formats.find(camera);
        if (open_now != formats.end() && !open_now->second.contains(format) &&
            open_now->second.size() >= state.options.limits.qualities_per_camera) {
            std::string in_use;
            for (const auto& [one, streams] : open_now->second)
                in_use += (in_use.empty() ? "" : ", ") + std::to_string(one.quality);
            return error(ErrorKind::resource_exhausted,
                         "camera " + camera + " is streamed in as many qualities as allowed; use one of " + in_use);
        }
        ++formats[camera][format];
        return EncodingShare(state, camera, format);
    }
    EncodingShare(EncodingShare&& other) noexcept
        : state_(std::exchange(other.state_, nullptr)), camera_(std::move(other.camera_)), format_(other.format_) {}
    EncodingShare& operator=(EncodingShare&&) = delete;
    ~EncodingShare() {
        if (state_ == nullptr) return;
        auto& formats = state_->streams_by_format[camera_];
        if (--formats[format_] == 0) formats.erase(format_);
        if (formats.empty()) state_->streams_by_format.erase(camera_);
    }
    const stream::MediaFormat& format() const { return format_; }

private:
    EncodingShare(ServerState& state, std::string camera, const stream::MediaFormat& format)
        : state_(&state), camera_(std::move(camera)), format_(format) {}

    ServerState* state_;  ///< null: moved from
    std::string camera_;
    stream::MediaFormat format_;
};

}  // namespace camrig::http
