#pragma once

#include <filesystem>
#include <span>

#include "core/base/result.h"
#include "core/world/model.h"

namespace camrig::world {

/// Reads a .gltf or .glb file. Damaged, hostile and unsupported files are errors that name the file and the place in it
/// (e.g. "duck.glb: meshes[0].primitives[2].indices: ..."), never a crash; sizes are bounded before anything is
/// allocated.
Result<ModelRef> load_model(const std::filesystem::path& file);

/// The same from memory (binary or JSON form, told apart by the magic); external URIs resolve against `base`,
/// and are refused when `base` is empty.
Result<ModelRef> load_model(std::span<const std::byte> bytes, const std::filesystem::path& base, std::string_view name);

}  // namespace camrig::world
