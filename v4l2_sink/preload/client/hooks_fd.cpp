// Calls on descriptors. Everything that is not ours costs one relaxed load and goes on to libc.

#include <cerrno>

#include <fcntl.h>
#include <stdarg.h>
#include <sys/mman.h>
#include <sys/types.h>
#include <sys/uio.h>

#include "v4l2_sink/preload/client/device.h"
#include "v4l2_sink/preload/client/hook.h"
#include "v4l2_sink/preload/client/sys.h"

HOOK(int, ioctl, (int fd, unsigned long request, ...))
HOOK(int, close, (int fd))
HOOK(int, close_range, (unsigned first, unsigned last, int flags))
HOOK(void, closefrom, (int first))
HOOK(int, dup, (int fd))
HOOK(int, dup2, (int from, int to))
HOOK(int, dup3, (int from, int to, int flags))
HOOK(int, fcntl, (int fd, int command, ...))
HOOK(int, fcntl64, (int fd, int command, ...))
HOOK(void*, mmap, (void* at, size_t length, int protection, int flags, int fd, off_t offset))
HOOK(void*, mmap64, (void* at, size_t length, int protection, int flags, int fd, off_t offset))
HOOK(ssize_t, read, (int fd, void* to, size_t bytes))
HOOK(ssize_t, __read_chk, (int fd, void* to, size_t bytes, size_t room))
HOOK(ssize_t, readv, (int fd, const iovec* parts, int count))
HOOK(ssize_t, write, (int fd, const void* from, size_t bytes))

using namespace camrig::device;

namespace {

int ioctl_on_ours(Device& device, int fd, unsigned long request, void* argument) {
    const auto code = static_cast<unsigned>(request);  // some programs pass it sign-extended
    if (_IOC_TYPE(code) != 'V') return real::ioctl(fd, request, argument);
    const int saved = errno;
    const int problem = device_ioctl(device, fd, code, argument);
    if (problem != 0) return fail(problem);
    errno = saved;
    return 0;
}

/// Gives the copy of a descriptor its share of the device.
int adopt(int from, int to) {
    if (to < 0 || to >= max_fds || in_borrowed_memory()) return to;
    if (Device* device = acquire(from)) bind_fd(to, device);
    return to;
}

/// The number `fd` is about to be closed or replaced.
void give_up(int fd) {
    if (!is_ours(fd) || in_borrowed_memory()) return;
    if (is_hidden(fd))
        relocate_hidden(fd);
    else
        unbind_fd(fd);
}

template <typename Real>
int fcntl_on(const Real& next, int fd, int command, void* argument) {
    if (!is_ours(fd)) return next(fd, command, argument);
    if (is_hidden(fd) && !in_borrowed_memory()) return fail(EBADF);
    const int result = next(fd, command, argument);
    if (command == F_DUPFD || command == F_DUPFD_CLOEXEC) return adopt(fd, result);
    return result;
}

void* map_ours(Device& device, void* at, size_t length, int protection, int flags, off_t offset) {
    // The same demands as vb2_mmap() makes.
    const bool shared = (flags & MAP_SHARED) != 0;
    const int buffers =
        shared && (protection & PROT_READ) != 0 ? find_mapping(device, length, static_cast<uint64_t>(offset)) : -EINVAL;
    if (buffers < 0) {
        fail(-buffers);
        return MAP_FAILED;
    }
    return real::mmap(at, length, protection, flags, buffers, offset);
}

int close_span(unsigned first, unsigned last, int flags) {
    for (unsigned fd = first; fd <= last && fd < static_cast<unsigned>(max_fds); ++fd)
        if (!is_hidden(static_cast<int>(fd))) unbind_fd(static_cast<int>(fd));
    // Around our own descriptors.
    unsigned from = first;
    for (unsigned fd = first; fd <= last && fd < static_cast<unsigned>(max_fds); ++fd) {
        if (!is_hidden(static_cast<int>(fd))) continue;
        if (fd > from && raw_syscall(SYS_close_range, from, fd - 1, flags) < 0) return fail(ENOSYS);
        from = fd + 1;
    }
    if (from > last) return 0;
    return static_cast<int>(to_errno(raw_syscall(SYS_close_range, from, last, flags)));
}

}  // namespace

int hook_ioctl(int fd, unsigned long request, ...) {
    va_list rest;
    va_start(rest, request);
    void* argument = va_arg(rest, void*);
    va_end(rest);
    if (!is_ours(fd)) return real::ioctl(fd, request, argument);
    const Ref device(fd);
    return device.get() != nullptr ? ioctl_on_ours(*device.get(), fd, request, argument)
                                   : real::ioctl(fd, request, argument);
}

int hook_close(int fd) {
    if (is_ours(fd) && !in_borrowed_memory()) {
        if (is_hidden(fd)) return fail(EBADF);
        unbind_fd(fd);
    }
    return real::close(fd);
}

int hook_close_range(unsigned first, unsigned last, int flags) {
    constexpr int cloexec = 4;  // CLOSE_RANGE_CLOEXEC: nothing is closed now
    if (in_borrowed_memory() || (flags & cloexec) != 0) return real::close_range(first, last, flags);
    return close_span(first, last, flags);
}

void hook_closefrom(int first) {
    if (in_borrowed_memory())
        real::closefrom(first);
    else
        close_span(first < 0 ? 0u : static_cast<unsigned>(first), ~0u, 0);
}

int hook_dup(int fd) {
    const int copy = real::dup(fd);
    return is_ours(fd) ? adopt(fd, copy) : copy;
}

int hook_dup2(int from, int to) {
    if (from == to || real::fcntl(from, F_GETFD) < 0) return real::dup2(from, to);
    give_up(to);
    const int copy = real::dup2(from, to);
    return is_ours(from) ? adopt(from, copy) : copy;
}

int hook_dup3(int from, int to, int flags) {
    const bool fails = from == to || (flags & ~O_CLOEXEC) != 0 || real::fcntl(from, F_GETFD) < 0;
    if (fails) return real::dup3(from, to, flags);
    give_up(to);
    const int copy = real::dup3(from, to, flags);
    return is_ours(from) ? adopt(from, copy) : copy;
}

int hook_fcntl(int fd, int command, ...) {
    va_list rest;
    va_start(rest, command);
    void* argument = va_arg(rest, void*);
    va_end(rest);
    return fcntl_on(real::fcntl, fd, command, argument);
}

int hook_fcntl64(int fd, int command, ...) {
    va_list rest;
    va_start(rest, command);
    void* argument = va_arg(rest, void*);
    va_end(rest);
    return fcntl_on(real::fcntl64, fd, command, argument);
}

void* hook_mmap(void* at, size_t length, int protection, int flags, int fd, off_t offset) {
    if (is_ours(fd) && (flags & MAP_ANONYMOUS) == 0) {
        const Ref device(fd);
        if (device.get() != nullptr) return map_ours(*device.get(), at, length, protection, flags, offset);
    }
    return real::mmap(at, length, protection, flags, fd, offset);
}

void* hook_mmap64(void* at, size_t length, int protection, int flags, int fd, off_t offset) {
    return hook_mmap(at, length, protection, flags, fd, offset);
}

// read() and write() are not among the camera's abilities (V4L2_CAP_READWRITE); the socket must not answer for it.
ssize_t hook_read(int fd, void* to, size_t bytes) {
    if (is_ours(fd) && !is_hidden(fd)) return fail(EINVAL);
    return real::read(fd, to, bytes);
}

ssize_t hook___read_chk(int fd, void* to, size_t bytes, size_t room) {
    if (is_ours(fd) && !is_hidden(fd)) return fail(EINVAL);
    return real::__read_chk(fd, to, bytes, room);
}

ssize_t hook_readv(int fd, const iovec* parts, int count) {
    if (is_ours(fd) && !is_hidden(fd)) return fail(EINVAL);
    return real::readv(fd, parts, count);
}

ssize_t hook_write(int fd, const void* from, size_t bytes) {
    if (is_ours(fd) && !is_hidden(fd)) return fail(EINVAL);
    return real::write(fd, from, bytes);
}
