#include "tools/camrig/descriptors.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <spdlog/spdlog.h>
#include <sys/resource.h>

namespace camrig::cli {
namespace {

/// 512 of HTTP, 512 of RTSP with up to 4 UDP sockets each, 136 of control, some hundred of devices, and a reserve.
constexpr rlim_t wanted = 8192;
/// The same without UDP: below it the bounds of connections cannot be reached.
constexpr rlim_t needed = 2048;

}  // namespace

void raise_descriptor_limit() {
    rlimit limit{};
    if (::getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= wanted) return;
    limit.rlim_cur = std::min(wanted, limit.rlim_max);
    if (::setrlimit(RLIMIT_NOFILE, &limit) != 0)
        return spdlog::warn("the limit of open files stays as it is: {}", std::strerror(errno));
    if (limit.rlim_cur < needed)
        spdlog::warn(
            "at most {} open files are allowed, so not all connections that camrig can serve fit; raise the hard "
            "limit (ulimit -Hn, LimitNOFILE=) to {}",
            limit.rlim_cur, wanted);
}

}  // namespace camrig::cli
