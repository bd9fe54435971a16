#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <glm/glm.hpp>

/// What a bake has found so far, in a file, so that one that was ended goes on where it was.
namespace camrig::bake {

class Checkpoint {
public:
    /// title: of scene and options; what was found for others is not taken. An empty path: nothing is kept.
    Checkpoint(std::filesystem::path file, std::string title) : file_(std::move(file)), title_(std::move(title)) {}

    /// Light by layer and texel after so many passes, or 0 and what `light` was. `light` has the size that it must
    /// have.
    int resume(std::vector<std::vector<glm::vec3>>& light) const;
    /// A file that cannot be written is logged once; the bake goes on.
    void keep(int passes, const std::vector<std::vector<glm::vec3>>& light);

private:
    std::filesystem::path file_;
    std::string title_;
    bool has_failed_ = false;
};

}  // namespace camrig::bake
