#include "core/base/private_folder.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include <sys/stat.h>
#include <unistd.h>

namespace camrig {

Result<void> check_private_folder(const std::string& path) {
    struct stat facts{};
    if (::lstat(path.c_str(), &facts) != 0) return error(ErrorKind::unavailable, path + ": " + std::strerror(errno));
    if (!S_ISDIR(facts.st_mode))
        return error(ErrorKind::unavailable,
                     path + ": is no folder, but a folder of that name is needed; remove it: rm " + path);
    if (facts.st_uid != ::geteuid()) {
        return error(ErrorKind::unavailable, path + ": belongs to user " + std::to_string(facts.st_uid) +
                                                 ", not to user " + std::to_string(::geteuid()) +
                                                 ", who needs a private folder of that name; have it removed: rm -r " +
                                                 path);
    }
    if ((facts.st_mode & 0077) != 0)
        return error(ErrorKind::unavailable, path + ": is open to other users; remove it, or: chmod 700 " + path);
    return {};
}

Result<void> make_private_folder(const std::string& path) {
    if (::mkdir(path.c_str(), 0700) != 0 && errno != EEXIST)
        return error(ErrorKind::unavailable, path + ": cannot be made: " + std::strerror(errno));
    return check_private_folder(path);
}

std::string user_runtime_folder() {
    if (const char* folder = std::getenv("XDG_RUNTIME_DIR"); folder && *folder) return std::string(folder) + "/camrig";
    return "/tmp/camrig-" + std::to_string(::getuid());
}

}  // namespace camrig
