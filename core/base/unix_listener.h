#pragma once

#include <string>

#include <sys/socket.h>
#include <sys/types.h>

#include "core/base/result.h"
#include "core/base/unique_fd.h"

namespace camrig {

/// What a rig listens on and how messages call it.
struct UnixListenerOptions {
    const char* name = "control socket";
    int type = SOCK_STREAM;
};

/// A listening Unix socket (it does not block) and its file, which goes away with it unless somebody else's took its
/// place.
///
/// The file has mode 0600 from its first moment. A file left by a rig that is gone is replaced; one that somebody
/// listens on, or that is no socket, is an error.
class UnixListener {
public:
    /// already_exists: somebody listens there. unavailable: it cannot be made.
    static Result<UnixListener> listen(const std::string& path, UnixListenerOptions options = {});
    UnixListener() = default;
    UnixListener(UnixListener&& other) noexcept;
    UnixListener& operator=(UnixListener&& other) noexcept;
    ~UnixListener() { remove_file(); }

    int fd() const { return fd_.get(); }
    int release_fd() { return fd_.release(); }
    /// Removes the file if it is still ours.
    void remove_file() noexcept;

private:
    UniqueFd fd_;
    std::string path_;
    dev_t device_ = 0;
    ino_t inode_ = 0;
};

}  // namespace camrig
