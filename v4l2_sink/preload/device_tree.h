#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"

namespace camrig::device {

/// The small folder of real files from which programs under `camrig exec` see our part of /dev and /sys (client/paths.h
/// has its layout). It stands beside the socket as SOCKET.tree and is removed with its owner.
class DeviceTree {
public:
    /// Starts with an empty tree that only this user can enter; what a crashed rig left behind goes. unavailable: it
    /// cannot be removed or made, for instance because it is another user's.
    static Result<DeviceTree> create(std::string_view socket_path);
    DeviceTree(DeviceTree&& other) noexcept : root_(std::move(other.root_)) { other.root_.clear(); }
    DeviceTree& operator=(DeviceTree&&) = delete;
    ~DeviceTree();

    Result<void> add(int number, std::string_view camera);
    void remove(int number, std::string_view camera);

private:
    explicit DeviceTree(std::string root) : root_(std::move(root)) {}
    std::string root_;
};

}  // namespace camrig::device
