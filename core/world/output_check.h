#pragma once

#include <cstddef>
#include <vector>

#include "core/base/image_size.h"
#include "core/base/output_spec.h"
#include "core/base/result.h"

namespace camrig {

inline constexpr std::size_t max_outputs_per_camera = 16;

/// What is wrong with the outputs of a camera of this size, with the place ("outputs[1].codec: ...").
Result<void> check_outputs(const std::vector<OutputSpec>& outputs, ImageSize size);

}  // namespace camrig
