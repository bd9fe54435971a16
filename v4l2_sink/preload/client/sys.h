#pragma once

#include <cerrno>

#include <errno.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/syscall.h>

// System calls without libc in between: the library defines open(), ioctl(), syscall() ... itself, so its own calls
// must not come back to it, must not be cancellation points and must not touch errno unless they mean to.
namespace camrig::device {

#if defined(__x86_64__)
inline long raw_syscall(long number, long a = 0, long b = 0, long c = 0, long d = 0, long e = 0, long f = 0) {
    long result;
    register long r10 __asm__("r10") = d;
    register long r8 __asm__("r8") = e;
    register long r9 __asm__("r9") = f;
    __asm__ volatile("syscall"
                     : "=a"(result)
                     : "a"(number), "D"(a), "S"(b), "d"(c), "r"(r10), "r"(r8), "r"(r9)
                     : "rcx", "r11", "memory");
    return result;
}
#elif defined(__aarch64__)
inline long raw_syscall(long number, long a = 0, long b = 0, long c = 0, long d = 0, long e = 0, long f = 0) {
    register long x8 __asm__("x8") = number;
    register long x0 __asm__("x0") = a;
    register long x1 __asm__("x1") = b;
    register long x2 __asm__("x2") = c;
    register long x3 __asm__("x3") = d;
    register long x4 __asm__("x4") = e;
    register long x5 __asm__("x5") = f;
    __asm__ volatile("svc 0" : "+r"(x0) : "r"(x8), "r"(x1), "r"(x2), "r"(x3), "r"(x4), "r"(x5) : "memory");
    return x0;
}
#else
#error "camrig's device library knows x86-64 and AArch64"
#endif

inline long arg(const void* pointer) {
    return reinterpret_cast<long>(pointer);
}

/// Negative results of raw_syscall are -errno.
inline bool failed(long result) {
    return result < 0 && result >= -4095;
}

/// The libc convention: -1 and errno.
inline long to_errno(long result) {
    if (!failed(result)) return result;
    errno = static_cast<int>(-result);
    return -1;
}

inline int sys_close(int fd) {
    return static_cast<int>(raw_syscall(SYS_close, fd));
}
inline int sys_fcntl(int fd, int command, long value = 0) {
    return static_cast<int>(raw_syscall(SYS_fcntl, fd, command, value));
}
inline int sys_getpid() {
    return static_cast<int>(raw_syscall(SYS_getpid));
}

/// Maps memory; null when that fails.
inline void* sys_map(size_t bytes, int protection, int flags, int fd, uint64_t offset = 0) {
    const long result =
        raw_syscall(SYS_mmap, 0, static_cast<long>(bytes), protection, flags, fd, static_cast<long>(offset));
    return failed(result) ? nullptr : reinterpret_cast<void*>(result);
}
inline void sys_unmap(void* memory, size_t bytes) {
    if (memory != nullptr) raw_syscall(SYS_munmap, arg(memory), static_cast<long>(bytes));
}

}  // namespace camrig::device
