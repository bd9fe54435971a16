#pragma once

#include <span>

#include "core/fault/sending.h"
#include "rtsp_out/rtsp/annex_b.h"

namespace camrig::rtsp {

/// The access unit (Annex B byte stream) as a failing camera sends it: slices damaged or missing, all else whole.
/// Offsets of what is wrong are those of `access_unit`.
fault::Damaged damaged_video(const fault::FrameFaults& faults, std::span<const std::byte> access_unit, NalCodec codec);

}  // namespace camrig::rtsp
