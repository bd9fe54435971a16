#include "tools/view/textures.h"

#include <algorithm>

#include <GLFW/glfw3.h>

// Of OpenGL 1.2; the header that GLFW takes may stop at 1.1.
#ifndef GL_CLAMP_TO_EDGE
#define GL_CLAMP_TO_EDGE 0x812F
#endif

namespace camrig::view {

Textures::~Textures() {
    for (const auto& [name, texture] : textures_) ::glDeleteTextures(1, &texture.id);
}

void Textures::put(const std::string& name, const Picture& picture) {
    Texture& texture = textures_[name];
    if (texture.id == 0) ::glGenTextures(1, &texture.id);
    ::glBindTexture(GL_TEXTURE_2D, texture.id);
    ::glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    if (texture.width == picture.width && texture.height == picture.height) {
        ::glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, picture.width, picture.height, GL_RGBA, GL_UNSIGNED_BYTE,
                          picture.rgba.data());
        return;
    }
    for (const unsigned filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        ::glTexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
    for (const unsigned wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
        ::glTexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
    ::glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, picture.width, picture.height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                   picture.rgba.data());
    texture.width = picture.width;
    texture.height = picture.height;
}

ImTextureID Textures::find(const std::string& name) const {
    const auto found = textures_.find(name);
    return found == textures_.end() ? nullptr : reinterpret_cast<ImTextureID>(std::uintptr_t{found->second.id});
}

glm::dvec2 Textures::size(const std::string& name) const {
    const auto found = textures_.find(name);
    return found == textures_.end() ? glm::dvec2(0.0) : glm::dvec2(found->second.width, found->second.height);
}

void Textures::keep_only(const std::vector<std::string>& names) {
    std::erase_if(textures_, [&](const auto& item) {
        if (std::ranges::find(names, item.first) != names.end()) return false;
        ::glDeleteTextures(1, &item.second.id);
        return true;
    });
}

}  // namespace camrig::view
