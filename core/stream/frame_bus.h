#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/ids.h"
#include "core/base/output_spec.h"
#include "core/base/rate.h"
#include "core/base/result.h"
#include "core/fault/standing.h"
#include "core/stream/sink.h"
#include "core/stream/statistics.h"

namespace camrig::stream {

/// The numbers that a camera's sensor gives beside its picture.
struct SensorNumbers {
    frame::PixelFormat pixels = frame::PixelFormat::gray16;  ///< one of frame::number_formats
    int bits = 16;                                           ///< of the converter
    friend bool operator==(const SensorNumbers&, const SensorNumbers&) = default;
};

/// A camera as outputs see it.
struct CameraStream {
    CameraId id{};
    std::string name;
    ImageSize size;
    Rate rate;
    std::vector<OutputSpec> outputs = {};       ///< what its user wishes; each family of sinks looks for its own
    std::optional<SensorNumbers> numbers = {};  ///< nullopt: it has no sensor
    fault::Standing standing = {};              ///< how it fails for those who come
};

struct SubscribeOptions {
    std::string kind;  ///< "mjpeg", "v4l2", ...: for statistics and messages
    std::string peer;  ///< who reads
    std::optional<Rate>
        rate;  ///< at most this rate: of the camera's frames those are taken that are first at or after a tick of it
};

/// Hears of cameras that come, change and go. Engine's thread, one at a time: waits for nobody, writes a few small
/// files.
class CameraObserver {
public:
    virtual ~CameraObserver() = default;
    virtual void camera_added(const CameraStream& camera) = 0;
    virtual void camera_changed(const CameraStream& camera) = 0;
    virtual void camera_removed(const CameraStream& camera) = 0;
    /// Something changed that is no part of CameraStream: where it looks, its optics, its image controls.
    virtual void camera_adjusted(const CameraStream& camera) { (void)camera; }
};

/// Keeps one sink attached; detaches (and closes the sink) when it is destroyed. Movable, any thread.
class Subscription {
public:
    Subscription() = default;
    Subscription(Subscription&&) noexcept = default;
    Subscription& operator=(Subscription&& other) noexcept {
        reset();
        detach_ = std::exchange(other.detach_, nullptr);
        return *this;
    }
    ~Subscription() { reset(); }
    void reset() {
        if (auto detach = std::exchange(detach_, nullptr)) detach();
    }
    explicit Subscription(std::function<void()> detach) : detach_(std::move(detach)) {}

private:
    std::function<void()> detach_;
};

/// Brings frames from the engine to whoever watches. publish() never blocks; a slow output loses frames of its own
/// only.
///
/// One Output per (camera, MediaFormat) converts and encodes once for all its sinks, on a bounded worker pool.
/// Consumer side (subscribe, cameras, find, report): any thread. Producer side: the engine's thread.
class FrameBus {
public:
    virtual ~FrameBus() = default;

    /// Attaches a sink; its open() is called on a worker before the first write(). The sink is closed when the
    /// subscription goes, the camera is deleted or its size changes, or the sink fails; on_end (may be empty) then
    /// tells why, once, from a worker thread, unless the subscription was reset before its end began.
    virtual Result<Subscription> subscribe(std::string_view camera, const MediaFormat& format, SubscribeOptions options,
                                           std::shared_ptr<Sink> sink, std::function<void(Error)> on_end) = 0;
    virtual std::vector<CameraStream> cameras() const = 0;
    virtual Result<CameraStream> find(std::string_view camera) const = 0;
    /// Observers are told of present cameras at once (on the caller's thread). They must outlive the bus or be removed.
    virtual void add_observer(CameraObserver* observer) = 0;
    virtual void remove_observer(CameraObserver* observer) = 0;
    /// For the log of readers: `peer` came to an output of this kind and was refused by a fault of the camera
    /// (fault::Standing::refuses).
    virtual void note_refused(std::string_view camera, std::string_view output, std::string_view peer) = 0;
};

/// An instant that somebody holds: pictures of it can be asked for, of any camera, as long as he does. What it is, is
/// the engine's matter (engine::HeldInstant).
class Instant {
public:
    virtual ~Instant() = default;
};
using InstantRef = std::shared_ptr<const Instant>;

/// What a one-off request for a picture gives.
struct FetchRequest {
    std::string camera;
    frame::FrameKind kind = frame::FrameKind::color;
    TimeNs min_ns = 0;   ///< world time the picture must at least show; waits for it
    MediaFormat format;  ///< raw rgba8, jpeg or png
    /// Not null: the picture shows this instant, whether the camera is due then or not; min_ns says nothing.
    InstantRef instant = {};
    /// Asked before anything is drawn or, of a picture that is there already, encoded, with the picture's size; an
    /// error is the answer. May be empty. On the engine's thread; must not block.
    std::function<Result<void>(ImageSize)> admit = {};
};

/// The camera's latest due frame, rendered on demand when nobody was watching (snapshots, frame.get).
class FrameFetcher {
public:
    virtual ~FrameFetcher() = default;
    /// Any thread; `done` is called once and must not block: from another thread or, refused, from within fetch().
    virtual void fetch(FetchRequest request, std::function<void(Result<MediaUnit>)> done) = 0;
};

}  // namespace camrig::stream
