#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/fault/fault_plan.h"
#include "rtsp_out/rtsp/annex_b.h"

namespace camrig::rtsp {

/// The access unit (Annex B byte stream) as a failing camera sends it: slices damaged or missing, all else whole.
std::vector<std::byte> damaged_video(const fault::FrameFaults& faults, std::span<const std::byte> access_unit,
                                     NalCodec codec);

}  // namespace camrig::rtsp
