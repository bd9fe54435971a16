#pragma once

#include <string>
#include <utility>

#include "core/base/result.h"
#include "core/base/unique_fd.h"

namespace camrig::cli {

/// CONTROL.d: the private folder of a rig beside its control socket, with the socket and the files of its user-space
/// devices. Locked while the rig lives, so that two rigs started at once cannot share a control socket.
class RigFolder {
public:
    /// already_exists: another rig lives at this control socket; unavailable: the folder cannot be made, or is
    /// somebody else's.
    static Result<RigFolder> claim(const std::string& control);
    RigFolder(RigFolder&& other) noexcept : path_(std::exchange(other.path_, {})), lock_(std::move(other.lock_)) {}
    RigFolder& operator=(RigFolder&&) = delete;
    /// Removes the folder, once it is empty.
    ~RigFolder();

    static std::string path_of(const std::string& control) { return control + ".d"; }

private:
    RigFolder(std::string path, UniqueFd lock) : path_(std::move(path)), lock_(std::move(lock)) {}

    std::string path_;
    UniqueFd lock_;
};

/// The socket of a rig's user-space devices.
inline std::string device_socket_of(const std::string& control) {
    return RigFolder::path_of(control) + "/devices";
}
/// The same, absolute and without links: what programs are given, which go to other folders and compare it with names
/// that the kernel tells.
std::string real_device_socket_of(const std::string& control);

}  // namespace camrig::cli
