#pragma once

#include <filesystem>
#include <memory>
#include <span>

#include "core/base/result.h"
#include "core/world/backdrop/panorama.h"

namespace camrig::world {

/// A panorama with its details, whose files are absolute paths. The same files at the same places are in memory once,
/// as long as somebody has them: they may take some gigabytes. All of them are decoded here, so that no picture waits
/// for one when a camera first looks there. Errors have the field's path below the backdrop ("details[2].at_px: ...").
/// Any thread.
Result<std::shared_ptr<const Panorama>> read_panorama(const std::filesystem::path& file,
                                                      std::span<const PanoramaDetail> details);

}  // namespace camrig::world
