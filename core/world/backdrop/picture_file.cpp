#include "core/world/backdrop/picture_file.h"

#include <cstring>

#include "core/world/gltf/image_decode.h"
#include "core/world/gltf/resources.h"

namespace camrig::world {
namespace {

/// A JPEG as a camera wrote it may lie on its side, and say so (Exif 2.3, 4.6.4, tag 0x0112); 0 and 1: upright or not
/// said.
int orientation_of(std::span<const std::byte> bytes) {
    const auto at = [&](std::size_t i) { return i < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i]) : 0u; };
    if (at(0) != 0xFF || at(1) != 0xD8) return 1;
    for (std::size_t from = 2; at(from) == 0xFF && at(from + 1) >= 0xE0 && at(from + 1) <= 0xEF;) {
        const std::size_t length = at(from + 2) << 8 | at(from + 3), body = from + 4;
        if (at(from + 1) == 0xE1 && length > 8 && body + 6 <= bytes.size() &&
            std::memcmp(bytes.data() + body, "Exif\0\0", 6) == 0) {
            const std::size_t tiff = body + 6;
            const bool is_little = at(tiff) == 'I';
            const auto word = [&](std::size_t i) {
                return is_little ? at(i) | at(i + 1) << 8 : at(i) << 8 | at(i + 1);
            };
            const std::size_t directory =
                tiff + (is_little ? word(tiff + 4) | word(tiff + 6) << 16 : word(tiff + 4) << 16 | word(tiff + 6));
            const std::uint32_t entries = word(directory);
            for (std::uint32_t i = 0; i < entries && directory + 14 + 12 * i <= bytes.size(); ++i)
                if (word(directory + 2 + 12 * i) == 0x0112) return static_cast<int>(word(directory + 10 + 12 * i));
        }
        if (length < 2) break;
        from += 2 + length;
    }
    return 1;
}

}  // namespace

Result<PictureFile> PictureFile::open(const std::filesystem::path& file) {
    PictureFile opened;
    opened.file_ = file;
    try {
        opened.bytes_ = gltf::read_file(file, max_picture_bytes);
        if (const int turned = orientation_of(opened.bytes_); turned > 1)
            gltf::fail("", "is stored turned (Exif orientation " + std::to_string(turned) + "); save it upright",
                       ErrorKind::unsupported);
        opened.size_ = gltf::image_size(opened.bytes_, "");
    } catch (const gltf::Failure& failure) {
        return at(file.string(), failure.error);
    }
    return opened;
}

Result<Image> PictureFile::decode() const {
    try {
        gltf::Budget budget;
        return gltf::decode_image(bytes_, "", budget);
    } catch (const gltf::Failure& failure) {
        return at(file_.string(), failure.error);
    }
}

Result<Image> read_picture(const std::filesystem::path& file) {
    const auto opened = PictureFile::open(file);
    if (!opened) return std::unexpected(opened.error());
    return opened->decode();
}

}  // namespace camrig::world
