#pragma once

#include <map>
#include <string>

#include <glm/glm.hpp>
#include <imgui.h>

#include "tools/view/picture.h"

namespace camrig::view {

/// Pictures on the graphics card, by name. Lives and dies while the window's GL context is current.
class Textures {
public:
    Textures() = default;
    Textures(const Textures&) = delete;
    Textures& operator=(const Textures&) = delete;
    ~Textures();

    void put(const std::string& name, const Picture& picture);
    /// nullptr where there is none yet.
    ImTextureID find(const std::string& name) const;
    glm::dvec2 size(const std::string& name) const;
    void keep_only(const std::vector<std::string>& names);

private:
    struct Texture {
        unsigned id = 0;
        int width = 0;
        int height = 0;
    };
    std::map<std::string, Texture> textures_;
};

}  // namespace camrig::view
