#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/time.h"
#include "core/world/gltf/failure.h"

/// What one glTF file may ask for. Chosen far above real assets and far below what hurts the process.
namespace camrig::world::gltf {

inline constexpr std::size_t max_file_bytes = std::size_t{512} << 20;
inline constexpr std::size_t max_json_bytes = std::size_t{128} << 20;
/// All arrays and pictures of a model together, decoded.
inline constexpr std::size_t max_decoded_bytes = std::size_t{1} << 30;
inline constexpr int max_image_side = 16384;
inline constexpr std::size_t max_items = 1 << 17;  ///< nodes, meshes, materials, ... each
inline constexpr std::size_t max_vertices = std::size_t{1} << 24;
/// Over all nodes: a mesh may hang on a hundred thousand of them, and each costs its vertices in every picture.
inline constexpr std::size_t max_placed_vertices = std::size_t{1} << 26;
/// And each of these costs its place and its draw.
inline constexpr std::size_t max_placed_primitives = std::size_t{1} << 18;
inline constexpr std::size_t max_indices = std::size_t{1} << 26;
inline constexpr std::size_t max_placed_indices = std::size_t{1} << 28;  ///< over all nodes, as vertices
inline constexpr std::size_t max_morph_targets = 1024;
inline constexpr std::size_t max_joints = 65535;
inline constexpr std::size_t max_keys = std::size_t{1} << 22;
inline constexpr int max_node_depth = 1024;
inline constexpr double max_clip_s = 1e6;
inline constexpr double max_value = 1e10;  ///< of any coordinate, scale or weight
inline constexpr std::size_t max_name_bytes = 256;
inline constexpr std::size_t max_variant_colors = 1024;  ///< that one material comes in

/// Counts decoded bytes, so that a small file cannot ask for the same megabytes a thousand times.
class Budget {
public:
    void take(std::size_t bytes, std::string_view place) {
        if (bytes > max_decoded_bytes - used_) {
            fail(place, "the model needs more than " + std::to_string(max_decoded_bytes >> 20) + " MB decoded",
                 ErrorKind::resource_exhausted);
        }
        used_ += bytes;
    }

private:
    std::size_t used_ = 0;
};

}  // namespace camrig::world::gltf
