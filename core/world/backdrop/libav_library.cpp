#include "core/world/backdrop/libav_library.h"

#include <string>

#include <dlfcn.h>

namespace camrig::world {
namespace {

// As they were when camrig was built: other versions have other structures.
constexpr int avformat_version = LIBAVFORMAT_VERSION_MAJOR, avcodec_version = LIBAVCODEC_VERSION_MAJOR,
              avutil_version = LIBAVUTIL_VERSION_MAJOR, swscale_version = LIBSWSCALE_VERSION_MAJOR;

Result<LibavLibrary> load() {
    LibavLibrary made;
    const auto find = [](const std::string& library, int version, const char* function) -> Result<void*> {
        const std::string file = "lib" + library + ".so." + std::to_string(version);
        void* const opened = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
        void* const found = opened != nullptr ? dlsym(opened, function) : nullptr;
        if (found == nullptr)
            return error(ErrorKind::unsupported, "films need the libraries of FFmpeg (package lib" + library +
                                                     std::to_string(version) + "): " + dlerror());
        return found;
    };
#define CAMRIG_LIBAV_LOAD(library, name)                                    \
    {                                                                       \
        const auto found = find(#library, library##_version, #name);        \
        if (!found) return std::unexpected(found.error());                  \
        made.name = reinterpret_cast<decltype(LibavLibrary::name)>(*found); \
    }
    CAMRIG_LIBAV_FUNCTIONS(CAMRIG_LIBAV_LOAD)
#undef CAMRIG_LIBAV_LOAD
    return made;
}

}  // namespace

Result<const LibavLibrary*> LibavLibrary::open() {
    static const Result<LibavLibrary> library = load();
    if (!library) return std::unexpected(library.error());
    return &*library;
}

}  // namespace camrig::world
