#pragma once

#include <string>
#include <vector>

namespace camrig {

struct ExecOptions {
    std::string library;  ///< empty: libcamrig_device.so found beside the program or installed
    std::string socket;   ///< of the rig's devices
};

/// Becomes COMMAND with the rig's user-space devices in its sight (`camrig exec -- COMMAND...`): sets LD_PRELOAD and
/// CAMRIG_DEVICE_SOCKET and executes. Returns only on failure, after one line on stderr: 127 when the command was not
/// found, 126 when it cannot be executed, 2 for bad usage, 1 when the library is missing.
int exec_with_devices(const std::vector<std::string>& command, const ExecOptions& options);

/// The device library: $CAMRIG_DEVICE_LIBRARY, else beside this program, else ../lib/camrig, else in the build tree of
/// this program; empty when it is nowhere.
std::string find_device_library();

}  // namespace camrig
