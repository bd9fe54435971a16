#pragma once

#include <atomic>
#include <cerrno>

#include <dlfcn.h>
#include <errno.h>

// How a libc function is taken over. The hook has a name of its own and the libc name as its symbol, so that libc's
// headers (with their macros, fortified inlines and exception specifications) do not collide with it.
//
//   HOOK(int, dup, (int fd));            declares the hook and what it hides: real::dup(fd) calls the next definition
//   int hook_dup(int fd) { ... real::dup(fd) ... }
#define HOOK(result, name, parameters)                                                              \
    extern "C" __attribute__((visibility("default"))) result hook_##name parameters __asm__(#name); \
    namespace camrig::device::real {                                                                \
    inline constexpr char name_of_##name[] = #name;                                                 \
    inline Next<name_of_##name, result parameters> name;                                            \
    }

namespace camrig::device::real {

/// The definition behind ours, looked up at the first call (constructors of other libraries may come before ours).
template <const char* name, typename F>
class Next;

template <const char* name, typename R, typename... A>
class Next<name, R(A...)> {
public:
    template <typename... B>
    R operator()(B... arguments) const {
        return get()(arguments...);
    }
    using Function = R (*)(A...);
    Function get() const {
        void* known = cache_.load(std::memory_order_relaxed);
        if (known == nullptr) cache_.store(known = dlsym(RTLD_NEXT, name), std::memory_order_relaxed);
        return reinterpret_cast<Function>(known);
    }

private:
    mutable std::atomic<void*> cache_{nullptr};
};

template <const char* name, typename R, typename... A>
class Next<name, R(A..., ...)> {
public:
    template <typename... B>
    R operator()(B... arguments) const {
        void* known = cache_.load(std::memory_order_relaxed);
        if (known == nullptr) cache_.store(known = dlsym(RTLD_NEXT, name), std::memory_order_relaxed);
        return reinterpret_cast<R (*)(A..., ...)>(known)(arguments...);
    }

private:
    mutable std::atomic<void*> cache_{nullptr};
};

}  // namespace camrig::device::real

namespace camrig::device {

/// -1 with errno set.
inline int fail(int error_number) {
    errno = error_number;
    return -1;
}

}  // namespace camrig::device
