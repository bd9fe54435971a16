#include "tools/camrig/rig_folder.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

#include "core/base/private_folder.h"

namespace camrig::cli {
namespace {

/// How often a rig that ends may remove the folder between our making and our locking it.
constexpr int max_attempts = 100;

/// A rig that was told to end holds its folder until its last reader is gone; who starts the next one right behind it
/// waits for that.
constexpr auto patience = std::chrono::seconds(3);

/// False: somebody has the lock all the time. Where there are no locks there is nobody.
bool lock_within(std::chrono::milliseconds time, const UniqueFd& folder) {
    const auto end = std::chrono::steady_clock::now() + time;
    while (::flock(folder.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return true;
}

bool is_still_at(const UniqueFd& folder, const std::string& path) {
    struct stat held{}, named{};
    return ::fstat(folder.get(), &held) == 0 && ::lstat(path.c_str(), &named) == 0 && held.st_dev == named.st_dev &&
           held.st_ino == named.st_ino;
}

}  // namespace

Result<RigFolder> RigFolder::claim(const std::string& control) {
    const std::string path = path_of(control);
    for (int attempt = 0; attempt < max_attempts; ++attempt) {
        if (auto made = make_private_folder(path); !made)
            return error(made.error().kind, made.error().message + "; or choose another --control");
        UniqueFd folder(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
        if (!folder && errno != ENOENT) return error(ErrorKind::unavailable, path + ": " + std::strerror(errno));
        if (!folder) continue;
        // Some network file systems lock no folders; the sockets' own checks have to do there.
        if (!lock_within(patience, folder)) {
            return error(ErrorKind::already_exists,
                         "control socket " + control +
                             ": another rig lives there; end it (camrig call server.shutdown) or choose another "
                             "--control");
        }
        if (is_still_at(folder, path)) return RigFolder(path, std::move(folder));
    }
    return error(ErrorKind::unavailable, path + ": somebody removes it as often as it is made");
}

RigFolder::~RigFolder() {
    if (!path_.empty()) ::rmdir(path_.c_str());  // before the lock goes
}

std::string real_device_socket_of(const std::string& control) {
    namespace fs = std::filesystem;
    const fs::path socket = device_socket_of(control);
    std::error_code problem;
    fs::path folder = fs::absolute(socket.parent_path(), problem);
    if (!problem) folder = fs::weakly_canonical(folder, problem);  // it may not be there yet
    return problem ? socket.string() : (folder / socket.filename()).string();
}

}  // namespace camrig::cli
