#include "v4l2_sink/preload/exec.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>

#include <sys/un.h>
#include <unistd.h>

namespace camrig::device {

namespace fs = std::filesystem;

namespace {

constexpr const char* library_name = "libcamrig_device.so";

/// $CAMRIG_DEVICE_LIBRARY, else beside this program, else ../lib/camrig, else in the build tree of this program; empty
/// when it is nowhere.
std::string find_device_library() {
    if (const char* given = std::getenv("CAMRIG_DEVICE_LIBRARY"); given != nullptr && *given != '\0') return given;
    std::error_code problem;
    const fs::path program = fs::read_symlink("/proc/self/exe", problem);
    if (problem) return {};
    const fs::path folder = program.parent_path();
    for (const fs::path& place : {folder / library_name, folder / ".." / "lib" / "camrig" / library_name,
                                  folder / ".." / ".." / "v4l2_sink" / "preload" / library_name})
        if (fs::exists(place, problem)) return fs::weakly_canonical(place, problem).string();
    return {};
}

}  // namespace

int exec_with_devices(const std::vector<std::string>& command, const std::string& device_socket) {
    if (command.empty()) {
        std::fprintf(stderr, "camrig exec: no command; use: camrig exec -- COMMAND...\n");
        return 2;
    }
    const std::string library = find_device_library();
    if (library.empty() || ::access(library.c_str(), R_OK) != 0) {
        std::fprintf(stderr, "camrig exec: %s not found; set CAMRIG_DEVICE_LIBRARY to its path\n", library_name);
        return 1;
    }
    if (device_socket.size() >= sizeof(sockaddr_un::sun_path)) {
        std::fprintf(stderr, "camrig exec: %s: a socket's name may have %zu bytes; choose a shorter --control\n",
                     device_socket.c_str(), sizeof(sockaddr_un::sun_path) - 1);
        return 1;
    }
    if (library.find_first_of(" :") != std::string::npos) {
        std::fprintf(stderr,
                     "camrig exec: %s: LD_PRELOAD takes no name with a blank or a colon; set CAMRIG_DEVICE_LIBRARY to "
                     "a link without them\n",
                     library.c_str());
        return 1;
    }
    // It may be started after the program, which then finds its devices.
    if (::access(device_socket.c_str(), F_OK) != 0)
        std::fprintf(stderr, "camrig exec: no rig at %s: until one is started there are no devices\n",
                     device_socket.c_str());
    const char* before = std::getenv("LD_PRELOAD");
    const std::string preload = before != nullptr && *before != '\0' ? library + ":" + before : library;
    ::setenv("LD_PRELOAD", preload.c_str(), 1);
    ::setenv("CAMRIG_DEVICE_SOCKET", device_socket.c_str(), 1);

    std::vector<char*> arguments;
    for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
    arguments.push_back(nullptr);
    ::execvp(arguments[0], arguments.data());
    const int why = errno;
    std::fprintf(stderr, "camrig exec: %s: %s\n", arguments[0], std::strerror(why));
    return why == ENOENT ? 127 : 126;
}

}  // namespace camrig::device
