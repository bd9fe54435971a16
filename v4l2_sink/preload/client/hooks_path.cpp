// Calls that name a file: /dev/videoN opens a camera, its neighbours in /dev and /sys are read from the rig's tree.

#include <fcntl.h>
#include <linux/magic.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/vfs.h>

#include "v4l2_sink/preload/client/device.h"
#include "v4l2_sink/preload/client/hook.h"
#include "v4l2_sink/preload/client/paths.h"
#include "v4l2_sink/preload/client/sys.h"

HOOK(int, open, (const char* name, int flags, ...))
HOOK(int, open64, (const char* name, int flags, ...))
HOOK(int, openat, (int directory, const char* name, int flags, ...))
HOOK(int, openat64, (int directory, const char* name, int flags, ...))
HOOK(int, __open_2, (const char* name, int flags))
HOOK(int, __open64_2, (const char* name, int flags))
HOOK(int, __openat_2, (int directory, const char* name, int flags))
HOOK(int, __openat64_2, (int directory, const char* name, int flags))
HOOK(FILE*, fopen, (const char* name, const char* mode))
HOOK(FILE*, fopen64, (const char* name, const char* mode))
HOOK(int, fclose, (FILE * file))
HOOK(int, stat, (const char* name, struct stat* info))
HOOK(int, stat64, (const char* name, struct stat* info))
HOOK(int, lstat, (const char* name, struct stat* info))
HOOK(int, lstat64, (const char* name, struct stat* info))
HOOK(int, fstat, (int fd, struct stat* info))
HOOK(int, fstat64, (int fd, struct stat* info))
HOOK(int, fstatat, (int directory, const char* name, struct stat* info, int flags))
HOOK(int, fstatat64, (int directory, const char* name, struct stat* info, int flags))
HOOK(int, __xstat, (int version, const char* name, struct stat* info))
HOOK(int, __xstat64, (int version, const char* name, struct stat* info))
HOOK(int, __lxstat, (int version, const char* name, struct stat* info))
HOOK(int, __lxstat64, (int version, const char* name, struct stat* info))
HOOK(int, __fxstat, (int version, int fd, struct stat* info))
HOOK(int, __fxstat64, (int version, int fd, struct stat* info))
HOOK(int, __fxstatat, (int version, int directory, const char* name, struct stat* info, int flags))
HOOK(int, __fxstatat64, (int version, int directory, const char* name, struct stat* info, int flags))
HOOK(int, statx, (int directory, const char* name, int flags, unsigned mask, struct statx* info))
HOOK(int, fstatfs, (int fd, struct statfs* info))
HOOK(int, fstatfs64, (int fd, struct statfs64* info))
HOOK(int, access, (const char* name, int mode))
HOOK(int, eaccess, (const char* name, int mode))
HOOK(int, euidaccess, (const char* name, int mode))
HOOK(int, faccessat, (int directory, const char* name, int mode, int flags))
HOOK(ssize_t, readlink, (const char* name, char* to, size_t room))
HOOK(ssize_t, readlinkat, (int directory, const char* name, char* to, size_t room))
HOOK(ssize_t, __readlink_chk, (const char* name, char* to, size_t length, size_t room))
HOOK(ssize_t, getxattr, (const char* name, const char* attribute, void* to, size_t room))
HOOK(ssize_t, lgetxattr, (const char* name, const char* attribute, void* to, size_t room))
HOOK(char*, realpath, (const char* name, char* to))
HOOK(char*, __realpath_chk, (const char* name, char* to, size_t room))
HOOK(char*, canonicalize_file_name, (const char* name))

using namespace camrig::device;

namespace {

constexpr int camera_mode = S_IFCHR | 0660;

bool takes_mode(int flags) {
    return (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE;
}

#define MODE_OF(flags)                 \
    unsigned mode = 0;                 \
    if (takes_mode(flags)) {           \
        va_list rest;                  \
        va_start(rest, flags);         \
        mode = va_arg(rest, unsigned); \
        va_end(rest);                  \
    }

/// Opens what is ours; false: not ours. `result` follows the libc convention.
bool open_ours(int directory, const char* name, int flags, int& result) {
    if (!may_be_ours(name)) return false;
    Place place;
    find_place(directory, name, place);
    if (place.kind == PlaceKind::node) {
        // With O_PATH too, which the kernel would not take to the driver: fstat() of it must tell the node, and no file
        // of the tree is a character device.
        const int fd = open_device(place.number, flags);
        result = fd < 0 ? fail(-fd) : fd;
        return true;
    }
    if (place.kind != PlaceKind::file) return false;
    result = static_cast<int>(to_errno(raw_syscall(SYS_openat, AT_FDCWD, arg(place.path), flags & ~O_CREAT, 0)));
    return true;
}

template <typename Real>
int open_with(const Real& next, const char* name, int flags, unsigned mode) {
    int result;
    return open_ours(AT_FDCWD, name, flags, result) ? result : next(name, flags, mode);
}
template <typename Real>
int openat_with(const Real& next, int directory, const char* name, int flags, unsigned mode) {
    int result;
    return open_ours(directory, name, flags, result) ? result : next(directory, name, flags, mode);
}

FILE* open_file(FILE* (*next)(const char*, const char*), const char* name, const char* mode) {
    if (!may_be_ours(name)) return next(name, mode);
    Place place;
    find_place(AT_FDCWD, name, place);
    if (place.kind == PlaceKind::file) return next(place.path, mode);
    if (place.kind != PlaceKind::node) return next(name, mode);
    const int fd = open_device(place.number, O_CLOEXEC);
    if (fd < 0) {
        fail(-fd);
        return nullptr;
    }
    return fdopen(fd, mode);
}

void describe(uint32_t number, struct stat& info) {
    memset(&info, 0, sizeof info);
    info.st_dev = 6;  // as devtmpfs often has
    info.st_ino = 1000 + number;
    info.st_mode = camera_mode;
    info.st_nlink = 1;
    info.st_rdev = makedev(video_major, number);
    info.st_blksize = 4096;
}

bool describe_fd(int fd, struct stat* info) {
    if (!is_ours(fd)) return false;
    const Ref device(fd);
    if (device.get() == nullptr) return false;
    describe(device.get()->number, *info);
    return true;
}

/// stat() of what is ours; false: not ours.
bool stat_ours(int directory, const char* name, struct stat* info, int flags, int& result) {
    if (name != nullptr && name[0] == 0 && (flags & AT_EMPTY_PATH) != 0) {
        result = 0;
        return describe_fd(directory, info);
    }
    if (!may_be_ours(name)) return false;
    Place place;
    find_place(directory, name, place);
    if (place.kind == PlaceKind::node && !(place.link && (flags & AT_SYMLINK_NOFOLLOW) != 0)) {
        describe(place.number, *info);
        result = 0;
        return true;
    }
    if (place.kind != PlaceKind::file && place.kind != PlaceKind::node) return false;
    result = static_cast<int>(
        to_errno(raw_syscall(SYS_newfstatat, AT_FDCWD, arg(place.path), arg(info), flags & AT_SYMLINK_NOFOLLOW)));
    return true;
}

int access_ours(int directory, const char* name, int mode, bool& ours) {
    ours = false;
    if (!may_be_ours(name)) return 0;
    Place place;
    find_place(directory, name, place);
    if (place.kind != PlaceKind::node && place.kind != PlaceKind::file) return 0;
    ours = true;
    if (place.kind == PlaceKind::node) return (mode & 1) != 0 ? fail(EACCES) : 0;  // X_OK
    return static_cast<int>(to_errno(raw_syscall(SYS_faccessat, AT_FDCWD, arg(place.path), mode)));
}

bool readlink_ours(int directory, const char* name, char* to, size_t room, ssize_t& result) {
    if (!may_be_ours(name)) return false;
    Place place;
    find_place(directory, name, place);
    if (place.kind != PlaceKind::node && place.kind != PlaceKind::file) return false;
    result = place.kind == PlaceKind::node && !place.link
                 ? fail(EINVAL)
                 : to_errno(raw_syscall(SYS_readlinkat, AT_FDCWD, arg(place.path), arg(to), static_cast<long>(room)));
    return true;
}

bool is_ours_at_all(const char* name) {
    if (!may_be_ours(name)) return false;
    Place place;
    find_place(AT_FDCWD, name, place);
    return place.kind == PlaceKind::node || place.kind == PlaceKind::file;
}

/// The canonical name of what is ours; null: not ours.
char* canonical(const char* name, char* to) {
    if (!may_be_ours(name)) return nullptr;
    Place place;
    find_place(AT_FDCWD, name, place);
    char text[PATH_MAX];
    if (place.kind == PlaceKind::node) {
        snprintf(text, sizeof text, "/dev/video%u", place.number);
    } else if (place.kind == PlaceKind::file) {
        // Inside the tree libc resolves the links; what is in front of /dev or /sys is cut off again.
        char inside[PATH_MAX], root[PATH_MAX];
        if (real::realpath(place.path, inside) == nullptr || real::realpath(tree_path(), root) == nullptr)
            return nullptr;
        if (strncmp(inside, root, strlen(root)) != 0) return nullptr;
        strcpy(text, inside + strlen(root));
    } else {
        return nullptr;
    }
    return to != nullptr ? strcpy(to, text) : strdup(text);
}

}  // namespace

int hook_open(const char* name, int flags, ...) {
    MODE_OF(flags)
    return open_with(real::open, name, flags, mode);
}
int hook_open64(const char* name, int flags, ...) {
    MODE_OF(flags)
    return open_with(real::open64, name, flags, mode);
}
int hook_openat(int directory, const char* name, int flags, ...) {
    MODE_OF(flags)
    return openat_with(real::openat, directory, name, flags, mode);
}
int hook_openat64(int directory, const char* name, int flags, ...) {
    MODE_OF(flags)
    return openat_with(real::openat64, directory, name, flags, mode);
}
int hook___open_2(const char* name, int flags) {
    int result;
    return open_ours(AT_FDCWD, name, flags, result) ? result : real::__open_2(name, flags);
}
int hook___open64_2(const char* name, int flags) {
    int result;
    return open_ours(AT_FDCWD, name, flags, result) ? result : real::__open64_2(name, flags);
}
int hook___openat_2(int directory, const char* name, int flags) {
    int result;
    return open_ours(directory, name, flags, result) ? result : real::__openat_2(directory, name, flags);
}
int hook___openat64_2(int directory, const char* name, int flags) {
    int result;
    return open_ours(directory, name, flags, result) ? result : real::__openat64_2(directory, name, flags);
}
FILE* hook_fopen(const char* name, const char* mode) {
    return open_file(real::fopen.get(), name, mode);
}
FILE* hook_fopen64(const char* name, const char* mode) {
    return open_file(real::fopen64.get(), name, mode);
}

// libc closes the descriptor by a name of its own, and its number may be another file's a moment later.
int hook_fclose(FILE* file) {
    const int fd = file != nullptr ? fileno(file) : -1;
    if (is_ours(fd) && !in_borrowed_memory()) unbind_fd(fd);
    return real::fclose(file);
}

int hook_stat(const char* name, struct stat* info) {
    int result;
    return stat_ours(AT_FDCWD, name, info, 0, result) ? result : real::stat(name, info);
}
int hook_stat64(const char* name, struct stat* info) {
    int result;
    return stat_ours(AT_FDCWD, name, info, 0, result) ? result : real::stat64(name, info);
}
int hook_lstat(const char* name, struct stat* info) {
    int result;
    return stat_ours(AT_FDCWD, name, info, AT_SYMLINK_NOFOLLOW, result) ? result : real::lstat(name, info);
}
int hook_lstat64(const char* name, struct stat* info) {
    int result;
    return stat_ours(AT_FDCWD, name, info, AT_SYMLINK_NOFOLLOW, result) ? result : real::lstat64(name, info);
}
int hook_fstat(int fd, struct stat* info) {
    return describe_fd(fd, info) ? 0 : real::fstat(fd, info);
}
int hook_fstat64(int fd, struct stat* info) {
    return describe_fd(fd, info) ? 0 : real::fstat64(fd, info);
}
int hook_fstatat(int directory, const char* name, struct stat* info, int flags) {
    int result;
    return stat_ours(directory, name, info, flags, result) ? result : real::fstatat(directory, name, info, flags);
}
int hook_fstatat64(int directory, const char* name, struct stat* info, int flags) {
    int result;
    return stat_ours(directory, name, info, flags, result) ? result : real::fstatat64(directory, name, info, flags);
}

// Programs built against glibc before 2.33.
int hook___xstat(int version, const char* name, struct stat* info) {
    int result;
    return stat_ours(AT_FDCWD, name, info, 0, result) ? result : real::__xstat(version, name, info);
}
int hook___xstat64(int version, const char* name, struct stat* info) {
    int result;
    return stat_ours(AT_FDCWD, name, info, 0, result) ? result : real::__xstat64(version, name, info);
}
int hook___lxstat(int version, const char* name, struct stat* info) {
    int result;
    return stat_ours(AT_FDCWD, name, info, AT_SYMLINK_NOFOLLOW, result) ? result : real::__lxstat(version, name, info);
}
int hook___lxstat64(int version, const char* name, struct stat* info) {
    int result;
    return stat_ours(AT_FDCWD, name, info, AT_SYMLINK_NOFOLLOW, result) ? result
                                                                        : real::__lxstat64(version, name, info);
}
int hook___fxstat(int version, int fd, struct stat* info) {
    return describe_fd(fd, info) ? 0 : real::__fxstat(version, fd, info);
}
int hook___fxstat64(int version, int fd, struct stat* info) {
    return describe_fd(fd, info) ? 0 : real::__fxstat64(version, fd, info);
}
int hook___fxstatat(int version, int directory, const char* name, struct stat* info, int flags) {
    int result;
    return stat_ours(directory, name, info, flags, result) ? result
                                                           : real::__fxstatat(version, directory, name, info, flags);
}
int hook___fxstatat64(int version, int directory, const char* name, struct stat* info, int flags) {
    int result;
    return stat_ours(directory, name, info, flags, result) ? result
                                                           : real::__fxstatat64(version, directory, name, info, flags);
}

int hook_statx(int directory, const char* name, int flags, unsigned mask, struct statx* info) {
    struct stat simple;
    int result;
    if (!stat_ours(directory, name, &simple, flags, result)) return real::statx(directory, name, flags, mask, info);
    if (result != 0) return result;
    memset(info, 0, sizeof *info);
    info->stx_mask = STATX_BASIC_STATS & mask;
    info->stx_blksize = static_cast<uint32_t>(simple.st_blksize);
    info->stx_nlink = static_cast<uint32_t>(simple.st_nlink);
    info->stx_uid = simple.st_uid;
    info->stx_gid = simple.st_gid;
    info->stx_mode = static_cast<uint16_t>(simple.st_mode);
    info->stx_ino = simple.st_ino;
    info->stx_size = static_cast<uint64_t>(simple.st_size);
    info->stx_rdev_major = major(simple.st_rdev);
    info->stx_rdev_minor = minor(simple.st_rdev);
    info->stx_dev_major = major(simple.st_dev);
    info->stx_dev_minor = minor(simple.st_dev);
    return 0;
}

// libudev takes a device only from a file system of the kind that the kernel's /sys is.
int hook_fstatfs(int fd, struct statfs* info) {
    const int result = real::fstatfs(fd, info);
    if (result == 0 && is_in_our_sys(fd)) info->f_type = SYSFS_MAGIC;
    return result;
}
int hook_fstatfs64(int fd, struct statfs64* info) {
    const int result = real::fstatfs64(fd, info);
    if (result == 0 && is_in_our_sys(fd)) info->f_type = SYSFS_MAGIC;
    return result;
}

int hook_access(const char* name, int mode) {
    bool ours;
    const int result = access_ours(AT_FDCWD, name, mode, ours);
    return ours ? result : real::access(name, mode);
}
int hook_eaccess(const char* name, int mode) {
    bool ours;
    const int result = access_ours(AT_FDCWD, name, mode, ours);
    return ours ? result : real::eaccess(name, mode);
}
int hook_euidaccess(const char* name, int mode) {
    bool ours;
    const int result = access_ours(AT_FDCWD, name, mode, ours);
    return ours ? result : real::euidaccess(name, mode);
}
int hook_faccessat(int directory, const char* name, int mode, int flags) {
    bool ours;
    const int result = access_ours(directory, name, mode, ours);
    return ours ? result : real::faccessat(directory, name, mode, flags);
}

ssize_t hook_readlink(const char* name, char* to, size_t room) {
    ssize_t result;
    return readlink_ours(AT_FDCWD, name, to, room, result) ? result : real::readlink(name, to, room);
}
ssize_t hook_readlinkat(int directory, const char* name, char* to, size_t room) {
    ssize_t result;
    return readlink_ours(directory, name, to, room, result) ? result : real::readlinkat(directory, name, to, room);
}
ssize_t hook___readlink_chk(const char* name, char* to, size_t length, size_t room) {
    ssize_t result;
    return length <= room && readlink_ours(AT_FDCWD, name, to, length, result)
               ? result
               : real::__readlink_chk(name, to, length, room);
}
// `ls -l` asks for access lists.
ssize_t hook_getxattr(const char* name, const char* attribute, void* to, size_t room) {
    return is_ours_at_all(name) ? fail(ENOTSUP) : real::getxattr(name, attribute, to, room);
}
ssize_t hook_lgetxattr(const char* name, const char* attribute, void* to, size_t room) {
    return is_ours_at_all(name) ? fail(ENOTSUP) : real::lgetxattr(name, attribute, to, room);
}
char* hook_realpath(const char* name, char* to) {
    char* ours = canonical(name, to);
    return ours != nullptr ? ours : real::realpath(name, to);
}
char* hook___realpath_chk(const char* name, char* to, size_t room) {
    char* ours = room >= PATH_MAX ? canonical(name, to) : nullptr;
    return ours != nullptr ? ours : real::__realpath_chk(name, to, room);
}
char* hook_canonicalize_file_name(const char* name) {
    char* ours = canonical(name, nullptr);
    return ours != nullptr ? ours : real::canonicalize_file_name(name);
}
