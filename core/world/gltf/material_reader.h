#pragma once

#include <vector>

#include "core/world/gltf/document.h"
#include "core/world/model.h"

namespace camrig::world::gltf {

/// Materials with KHR_materials_unlit and KHR_texture_transform. Factors out of range are clamped. Throws Failure.
std::vector<Material> read_materials(const Document& document);

/// Textures with their samplers; every source exists. Throws Failure.
std::vector<Texture> read_textures(const Document& document);

/// Decoded pictures; those that no texture uses stay empty (they may be of a format only an extension reads).
std::vector<Image> read_images(const Document& document, Budget& budget);

}  // namespace camrig::world::gltf
