#include "core/base/result.h"

#include <cstdio>
#include <cstdlib>

namespace camrig {

std::string_view to_string(ErrorKind kind) {
    switch (kind) {
        case ErrorKind::invalid_argument:
            return "invalid_argument";
        case ErrorKind::not_found:
            return "not_found";
        case ErrorKind::already_exists:
            return "already_exists";
        case ErrorKind::unavailable:
            return "unavailable";
        case ErrorKind::unsupported:
            return "unsupported";
        case ErrorKind::resource_exhausted:
            return "resource_exhausted";
        case ErrorKind::unauthorized:
            return "unauthorized";
        case ErrorKind::internal:
            return "internal";
    }
    return "internal";
}

namespace detail {
void check_failed(const char* condition, const char* file, int line) {
    std::fprintf(stderr, "camrig: CHECK failed: %s (%s:%d)\n", condition, file, line);
    std::abort();
}
}  // namespace detail

}  // namespace camrig
