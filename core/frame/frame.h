#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/base/image_size.h"
#include "core/base/named.h"
#include "core/base/time.h"
#include "core/frame/changed_rows.h"
#include "core/frame/pixel_format.h"

namespace camrig {

/// What a frame's pixels mean.
enum class FrameKind : std::uint8_t {
    color,     ///< sRGB, in one of color_formats; alpha, where there is one, 255
    depth,     ///< depth32f: metres along the optical axis, +inf where nothing is
    instance,  ///< id32: ObjectId, 0 where nothing is
    semantic,  ///< id32: class number
    normal,    ///< normal32f: 3 floats, optical frame, 0 where nothing is
};
inline constexpr int frame_kind_count = 5;
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
    /// Sequence of a frame of this camera, kind and size, drawn before, that this one equals, byte for byte in any one
    /// format, in all rows outside of changed_rows; -1: not known.
    std::int64_t same_as = -1;
    ChangedRows changed_rows{};
};

/// Pixels of one picture, top row first, rows without padding, planes one after the other (see pixel_format.h).
/// Immutable once it is shared; its memory goes back to the pool when the last reference is gone.
class Frame {
public:
    Frame(FrameInfo frame_info, std::vector<std::byte> bytes, std::uint64_t held = 0)
        : info_(std::move(frame_info)), bytes_(std::move(bytes)), held_(held) {}

    const FrameInfo& info() const { return info_; }
    std::span<const std::byte> bytes() const { return bytes_; }
    /// For the maker of the frame only, before it is shared.
    std::span<std::byte> mutable_bytes() { return bytes_; }
    void mark_changes(std::int64_t same_as, const ChangedRows& rows) {
        info_.same_as = same_as;
        info_.changed_rows = rows;
    }
    void mark_changed(int first_row, int end_row) { info_.changed_rows.add(first_row, end_row); }
    std::vector<std::byte> take_bytes() && { return std::move(bytes_); }

    /// A number for what the bytes are once the frame is made, from whoever made it and never used before; 0: none.
    void mark_content(std::uint64_t mark) { mark_ = mark; }
    std::uint64_t content_mark() const { return mark_; }
    /// The mark of what these bytes were when the memory came from the pool: the maker need not write again what it
    /// knows to be there.
    std::uint64_t held_before() const { return held_; }

private:
    FrameInfo info_;
    std::vector<std::byte> bytes_;
    std::uint64_t held_ = 0, mark_ = 0;
};

using FrameRef = std::shared_ptr<const Frame>;

/// All frames of one instant.
struct FrameSet {
    TimeNs world_ns = 0;
    TimeNs monotonic_ns = 0;
    std::vector<FrameRef> frames;
};

}  // namespace camrig
