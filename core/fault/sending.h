#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/base/image_size.h"
#include "core/fault/fault_plan.h"

/// Layer transport: what becomes of a frame on its way to readers of an output, which is told by its kind ("mjpeg",
/// "rtsp", "device", "v4l2"). Pure functions.
namespace camrig::fault {

/// Nothing is sent, neither this frame nor what the output would send in its place; by an unplugged device, too.
bool is_stalled(const FrameFaults& faults, std::string_view output);
/// Its readers are thrown out. Never those of "v4l2": a loopback device cannot be unplugged while it is open.
bool is_disconnected(const FrameFaults& faults, std::string_view output);
/// They are, and their connections are reset, without a word.
bool is_reset(const FrameFaults& faults, std::string_view output);
/// A picture as it arrives, and what is wrong with it by each fault that did something.
struct Damaged {
    std::vector<std::byte> bytes;
    std::vector<Harm> harms;
};
/// The JPEG as it arrives; nullopt: unharmed.
std::optional<Damaged> damaged_jpeg(const FrameFaults& faults, std::string_view output,
                                    std::span<const std::byte> jpeg);
/// The connection is closed in the middle of this frame's part of an HTTP stream: what of so many bytes is missing;
/// nullopt: nothing.
std::optional<Harm> cut_part(const FrameFaults& faults, std::size_t bytes);
/// What a fault does to a picture of so many bytes that it keeps back whole.
Harm whole_loss(const Fault& fault, std::size_t bytes);
/// The fault by which the RTP packet of that number, sent while this frame was the newest, is lost; null: it is not.
const Fault* packet_loser(const FrameFaults& faults, std::uint64_t packet);
/// So many later packets of its picture overtake this one, numbered so too.
int packet_distance(const FrameFaults& faults, std::uint64_t packet);
/// So much world time later it comes than it was sent, numbered so too.
TimeNs packet_delay_ns(const FrameFaults& faults, std::uint64_t packet);
/// RTP has a new source (SSRC) whenever this is another.
std::uint64_t ssrc_epoch(const FrameFaults& faults);
/// A JPEG of this frame has this size; nullopt: the camera's.
std::optional<ImageSize> other_size(const FrameFaults& faults, std::string_view output, ImageSize size);

/// What is wrong with this frame's part of an HTTP stream.
std::optional<PartError> part_error(const FrameFaults& faults);
/// The fault by which slice `index` of the frame's H.264 or H.265 access unit is not sent; null: it is.
const Fault* slice_dropper(const FrameFaults& faults, std::uint64_t index, bool is_key);
/// Flips bits of what follows that slice's headers, so far behind the begin of an access unit of that size; no start
/// code comes about. Adds what it did to `harms`.
void damage_slice(const FrameFaults& faults, std::uint64_t index, std::span<std::byte> payload, std::size_t offset,
                  std::size_t size, std::vector<Harm>& harms);
/// That of a fault among those of a picture of so many bytes; made, if there is none yet.
Harm& harm_of(std::vector<Harm>& harms, const Fault& fault, std::size_t size);
/// A user-space device hands this frame out with the error flag.
bool has_buffer_error(const FrameFaults& faults);
/// What of the frame's bytes a user-space device does not hand out; nullopt: it hands out all.
std::optional<Harm> bytes_missing(const FrameFaults& faults, std::size_t bytes);
/// Its user-space devices are not there; null: they are.
const Unplug* unplug_of(const FrameFaults& faults);

/// Errors, before it is set, for what no output can do so. unsupported: with the reason.
Result<void> check_sending(const FaultKind& kind);

}  // namespace camrig::fault
