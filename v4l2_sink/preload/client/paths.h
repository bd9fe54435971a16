#pragma once

#include <limits.h>
#include <stdint.h>

// Which names in /dev, /sys and /run/udev are ours. The rig keeps a small tree of real files beside its socket
// (SOCKET.tree) that looks like the parts of them a camera has: dev/videoN (empty), dev/v4l/by-id/...,
// sys/class/video4linux/videoN/ {name,index,dev,uevent,subsystem}, sys/dev/char/81:N, run/udev/data/c81:N (what udev
// knows of it, for libudev). A name that exists there is ours; everything else goes to the kernel untouched.
namespace camrig::device {

/// $CAMRIG_DEVICE_SOCKET; empty: there is no rig, and nothing is ours.
const char* socket_path();
/// The folder of the tree.
const char* tree_path();
/// Done when the library is loaded; again when a test has changed the environment.
void read_environment();

inline constexpr int video_major = 81;

enum class PlaceKind : uint8_t {
    foreign,  ///< not ours
    node,     ///< /dev/videoN
    file,     ///< a file or folder that exists only in our tree: use `path` instead
    merged,   ///< a folder that exists both in the system and in our tree (`path`)
};

struct Place {
    PlaceKind kind = PlaceKind::foreign;
    uint32_t number = 0;
    bool link = false;    ///< the name given was a symbolic link to the node
    char path[PATH_MAX];  ///< in our tree
};

/// Could this name be ours? Cheap; decides without a system call for nearly every name.
bool may_be_ours(const char* name);
/// Is this descriptor a file or folder of our part of /sys? Never changes errno.
bool is_in_our_sys(int fd);
/// Looks a name up, relative to `directory_fd` like openat(). Never changes errno.
void find_place(int directory_fd, const char* name, Place& place);

}  // namespace camrig::device
