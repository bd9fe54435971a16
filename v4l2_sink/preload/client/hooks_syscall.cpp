// syscall(): libv4l2 (and so VLC, guvcview, v4l2-ctl -w ...) opens and drives devices that way, past the libc names.

#include <cerrno>

#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "v4l2_sink/preload/client/device.h"
#include "v4l2_sink/preload/client/hook.h"
#include "v4l2_sink/preload/client/paths.h"
#include "v4l2_sink/preload/client/sys.h"

HOOK(long, syscall, (long number, ...))

using namespace camrig::device;

namespace {

/// The libc function that does the same, when the call concerns us; false: not ours.
bool redirected(long number, const long* a, long& result) {
    switch (number) {
#ifdef SYS_open
        case SYS_open:
            if (!may_be_ours(reinterpret_cast<const char*>(a[0]))) return false;
            result = open(reinterpret_cast<const char*>(a[0]), static_cast<int>(a[1]), static_cast<mode_t>(a[2]));
            return true;
        case SYS_dup2:
            result = dup2(static_cast<int>(a[0]), static_cast<int>(a[1]));
            return true;
#endif
        case SYS_openat:
            if (!may_be_ours(reinterpret_cast<const char*>(a[1]))) return false;
            result = openat(static_cast<int>(a[0]), reinterpret_cast<const char*>(a[1]), static_cast<int>(a[2]),
                            static_cast<mode_t>(a[3]));
            return true;
        case SYS_dup3:
            result = dup3(static_cast<int>(a[0]), static_cast<int>(a[1]), static_cast<int>(a[2]));
            return true;
        default:
            break;
    }
    if (number != SYS_close && number != SYS_ioctl && number != SYS_read && number != SYS_mmap && number != SYS_dup &&
        number != SYS_fcntl && number != SYS_fstat)
        return false;
    const int fd = static_cast<int>(number == SYS_mmap ? a[4] : a[0]);
    if (!is_ours(fd)) return false;
    switch (number) {
        case SYS_close:
            result = close(fd);
            break;
        case SYS_read:
            result = read(fd, reinterpret_cast<void*>(a[1]), static_cast<size_t>(a[2]));
            break;
        case SYS_dup:
            result = dup(fd);
            break;
        case SYS_fcntl:
            result = fcntl(fd, static_cast<int>(a[1]), a[2]);
            break;
        case SYS_fstat:
            result = fstat(fd, reinterpret_cast<struct stat*>(a[1]));
            break;
        case SYS_mmap:
            result = arg(mmap(reinterpret_cast<void*>(a[0]), static_cast<size_t>(a[1]), static_cast<int>(a[2]),
                              static_cast<int>(a[3]), fd, a[5]));
            break;
        default: {
            const Ref device(fd);
            if (device.get() == nullptr || _IOC_TYPE(static_cast<unsigned>(a[1])) != 'V') return false;
            const int saved = errno;
            const int problem =
                device_ioctl(*device.get(), fd, static_cast<unsigned>(a[1]), reinterpret_cast<void*>(a[2]));
            result = problem != 0 ? fail(problem) : 0;
            if (problem == 0) errno = saved;
        }
    }
    return true;
}

}  // namespace

long hook_syscall(long number, ...) {
    long a[6];
    va_list rest;
    va_start(rest, number);
    for (long& value : a) value = va_arg(rest, long);
    va_end(rest);
    long result;
    if (redirected(number, a, result)) return result;
    return to_errno(raw_syscall(number, a[0], a[1], a[2], a[3], a[4], a[5]));
}
