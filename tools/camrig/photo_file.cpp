#include "tools/camrig/photo_file.h"

#include "core/world/gltf/image_decode.h"
#include "core/world/gltf/resources.h"

namespace camrig::cli {

namespace {
constexpr std::size_t max_photo_bytes = std::size_t{256} << 20;
}

Result<world::Image> read_photo(const std::filesystem::path& file) {
    try {
        world::gltf::Budget budget;
        return world::gltf::decode_image(world::gltf::read_file(file, max_photo_bytes), "", budget);
    } catch (const world::gltf::Failure& failure) {
        return at(file.string(), failure.error);
    }
}

}  // namespace camrig::cli
