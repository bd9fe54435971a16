#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/clock_reading.h"
#include "core/base/ids.h"
#include "core/base/image_size.h"
#include "core/base/named.h"
#include "core/base/sensor_reading.h"
#include "core/base/time.h"
#include "core/frame/damage.h"
#include "core/frame/pixel_format.h"

namespace camrig::fault {
struct FrameFaults;
}

namespace camrig::frame {

/// What a frame's pixels mean.
enum class FrameKind : std::uint8_t {
    color,     ///< sRGB, in one of color_formats; alpha, where there is one, 255
    depth,     ///< depth32f: metres along the optical axis, +inf where nothing is
    instance,  ///< id32: ObjectId, 0 where nothing is
    semantic,  ///< id32: class number
    normal,    ///< normal32f: 3 floats, optical frame, 0 where nothing is
    sensor,    ///< of a camera with a sensor: the numbers of its converter, in one of raw_formats
    /// flow32f: optical flow, pixels: where the point that a pixel shows will be in the camera's next frame, less where
    /// it is; NaN where nothing is, and of what the lens will not show then.
    flow,
    /// gray8: how much of a pixel's light dirt, drops, condensation and covers on the lens take or bring from
    /// elsewhere, 0: none, 255: all. Not drawn: faults say it.
    soiling,
};
inline constexpr int frame_kind_count = 8;
/// Of arrays and sets by kind.
constexpr std::size_t index_of(FrameKind kind) {
    return static_cast<std::size_t>(kind);
}
/// The first of them, which every renderer draws of every camera.
inline constexpr int scene_kind_count = 5;
std::span<const Named<FrameKind>> names_of(std::type_identity<FrameKind>);

/// What a frame shows and when. All cameras due at one instant carry the same world_ns and monotonic_ns.
struct FrameInfo {
    CameraId camera_id{};
    std::shared_ptr<const std::string> camera;  ///< its name; never null
    std::int64_t sequence = 0;                  ///< strictly rising per camera; gaps are dropped frames
    TimeNs world_ns = 0;
    TimeNs monotonic_ns = 0;
    ImageSize size;
    FrameKind kind = FrameKind::color;
    PixelFormat format = PixelFormat::rgba8;
    Damage damage{};                        ///< since an earlier frame of this camera, kind and size, by its sequence
    std::optional<ClockReading> clock{};    ///< of a camera that has its own: what it says of what is stamped
    std::optional<SensorReading> sensor{};  ///< of a camera that has one: how the picture is taken
    std::shared_ptr<const fault::FrameFaults> faults{};  ///< what fails on its way out too; null: nothing does

    /// What is stamped: the instant, or where there is a sensor the begin of its first row's exposure, which is so long
    /// before it.
    TimeNs taken_for_ns() const { return sensor ? world_ns - sensor->exposure_start_ns : 0; }
    /// It as the camera's time of day has it, where world time is the true one.
    TimeNs stamp_ns() const { return world_ns - taken_for_ns() + (clock ? clock->stamp_error_ns : 0); }
    /// The same as its monotonic clock has it, where CLOCK_MONOTONIC is the true one.
    TimeNs steady_ns() const { return monotonic_ns - taken_for_ns() + (clock ? clock->steady_error_ns : 0); }
};

/// Whether `info.damage` is the damage since this earlier frame.
inline bool is_damage_since(const FrameInfo& earlier, const FrameInfo& info) {
    return info.damage.base() == earlier.sequence && info.camera_id == earlier.camera_id && info.kind == earlier.kind &&
           info.size == earlier.size;
}

/// Pixels of one picture, top row first, rows without padding, planes one after the other (see pixel_format.h).
/// Immutable once it is shared; its memory goes back to the pool when the last reference is gone.
class Frame {
public:
    Frame(FrameInfo frame_info, std::vector<std::byte> bytes, std::uint64_t held = 0)
        : info_(std::move(frame_info)), bytes_(std::move(bytes)), held_(held) {}
    /// The picture of another frame, with its bytes, as a frame of its own.
    Frame(FrameInfo frame_info, std::shared_ptr<const Frame> shown)
        : info_(std::move(frame_info)), shown_(std::move(shown)) {}

    const FrameInfo& info() const { return info_; }
    std::span<const std::byte> bytes() const { return shown_ ? shown_->bytes() : bytes_; }
    /// For the maker of the frame only, before it is shared.
    std::span<std::byte> mutable_bytes() { return bytes_; }
    void set_damage(const Damage& damage) { info_.damage = damage; }
    void add_damage(int first_row, int end_row) { info_.damage.add(first_row, end_row); }
    std::vector<std::byte> take_bytes() && { return std::move(bytes_); }

    /// The pool gives a camera the memory of its own earlier frames. Who makes frames may give the bytes of each a
    /// number, never the same twice; 0: none.
    void mark_content(std::uint64_t mark) { mark_ = mark; }
    std::uint64_t content_mark() const { return mark_; }
    /// The number of the bytes that this memory still has from an earlier frame: the maker knows what they are and need
    /// write only where this frame is another.
    std::uint64_t held_before() const { return held_; }

private:
    FrameInfo info_;
    std::vector<std::byte> bytes_;
    std::shared_ptr<const Frame> shown_;  ///< whose bytes these are; null: its own
    std::uint64_t held_ = 0, mark_ = 0;
};

using FrameRef = std::shared_ptr<const Frame>;

/// All frames of one instant.
struct FrameSet {
    TimeNs world_ns = 0;
    TimeNs monotonic_ns = 0;
    std::vector<FrameRef> frames;
};

}  // namespace camrig::frame
