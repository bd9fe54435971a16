#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/world/baked/baked_light.h"
#include "core/world/scene.h"

namespace camrig::world {

/// The file of a scene's light: beside the scene's, with this ending.
inline constexpr const char* baked_light_ending = ".light";
inline constexpr std::size_t max_baked_light_bytes = std::size_t{256} << 20;  ///< of a file

/// Light as bytes, as core/world/baked/light_bytes.h keeps it.
std::vector<std::byte> encode_baked_light(const BakedLight& light);

/// Checked against the scene that it is for, whose models are uncut. Errors: invalid_argument for bytes that are no
/// light of this scene, and `unsupported` where the scene has changed since.
Result<BakedLightRef> decode_baked_light(std::span<const std::byte> bytes, const Scene& scene);

/// The same of a file.
Result<BakedLightRef> read_baked_light(const std::filesystem::path& file, const Scene& scene);

/// The files that have light for a scene of that file: its own and those of its bases, the nearest first.
std::vector<std::filesystem::path> baked_light_files(const Scene& scene, const std::filesystem::path& scene_file);

/// What lies beside the scene's file or, if nothing does, of one that it stands on, is used. A light that is of another
/// state of the scene, or damaged, is left alone, and logged: the scene looks as without one.
void find_baked_light(Scene& scene, const std::filesystem::path& scene_file);

}  // namespace camrig::world
