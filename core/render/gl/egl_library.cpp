#include "core/render/gl/egl_library.h"

#include <array>
#include <filesystem>
#include <string_view>
#include <system_error>

#include <dlfcn.h>

namespace camrig::render::gl {
namespace {

Result<EglLibrary> load() {
    void* const library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr)
        return error(ErrorKind::unsupported,
                     std::string("OpenGL is not installed (packages libegl1 and libgl1-mesa-dri): ") + dlerror());
    EglLibrary egl;
#define CAMRIG_EGL_LOAD(name, type)                           \
    egl.name = reinterpret_cast<type>(dlsym(library, #name)); \
    if (egl.name == nullptr) return error(ErrorKind::unsupported, "libEGL.so.1 has no " #name "; EGL 1.5 is needed");
    CAMRIG_EGL_FUNCTIONS(CAMRIG_EGL_LOAD)
#undef CAMRIG_EGL_LOAD
    return egl;
}

bool has_entry(const char* folder, std::string_view beginning) {
    std::error_code failed;
    for (std::filesystem::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed))
        if (at->path().filename().native().starts_with(beginning)) return true;
    return false;
}

}  // namespace

Result<const EglLibrary*> EglLibrary::open() {
    static const Result<EglLibrary> library = load();
    if (!library) return std::unexpected(library.error());
    return &*library;
}

bool has_gpu_node() {
    // Of the kernel's own drivers, NVIDIA's, and Windows' below WSL.
    return has_entry("/dev/dri", "") || has_entry("/dev", "nvidia") || has_entry("/dev", "dxg");
}

}  // namespace camrig::render::gl
