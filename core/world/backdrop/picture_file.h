#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "core/world/model.h"

namespace camrig::world {

/// A PNG or JPEG of which only the head was looked at. 256 MiB at most, upright, of at most 16384 pixels a side. Errors
/// have the file's name.
class PictureFile {
public:
    static Result<PictureFile> open(const std::filesystem::path& file);
    ImageSize size() const { return size_; }
    Result<Image> decode() const;

private:
    PictureFile() = default;

    std::filesystem::path file_;
    std::vector<std::byte> bytes_;
    ImageSize size_;
};

Result<Image> read_picture(const std::filesystem::path& file);

/// Of any file that belongs to a backdrop.
inline constexpr std::size_t max_picture_bytes = std::size_t{256} << 20;

}  // namespace camrig::world
