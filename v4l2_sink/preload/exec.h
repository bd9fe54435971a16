#pragma once

#include <string>
#include <vector>

namespace camrig::device {

/// Replaces this process by COMMAND, which sees the rig's user-space devices (`camrig exec -- COMMAND...`): sets
/// LD_PRELOAD and CAMRIG_DEVICE_SOCKET and calls exec. Returns only on failure, after one line on stderr, with the exit
/// status: 127 when the command was not found, 126 when it cannot be executed, 2 for bad usage, 1 when the library is
/// missing.
int exec_with_devices(const std::vector<std::string>& command, const std::string& device_socket);

}  // namespace camrig::device
