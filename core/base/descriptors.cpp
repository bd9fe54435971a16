#include "core/base/descriptors.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstring>

#include <poll.h>
#include <sys/resource.h>

namespace camrig {
namespace {

/// 512 of HTTP, 512 of RTSP with up to 4 UDP sockets each, 136 of control, some hundred of devices, and a reserve.
constexpr rlim_t wanted = 8192;
/// The same without UDP: below it the bounds of connections cannot be reached.
constexpr rlim_t needed = 2048;

}  // namespace

bool descriptors_are_short(int reserve) {
    rlimit limit{};
    if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return false;
    // poll() marks numbers that are not open. The kernel gives the lowest that is free, so most are free at the top.
    std::array<pollfd, 256> numbers;
    auto end = static_cast<int>(std::min<rlim_t>(limit.rlim_cur, INT_MAX));
    for (std::ptrdiff_t free = 0; free < reserve;) {
        const int count = std::min(end, static_cast<int>(numbers.size()));
        if (count == 0) return true;
        end -= count;
        for (int i = 0; i < count; ++i)
            numbers[static_cast<std::size_t>(i)] = {.fd = end + i, .events = 0, .revents = 0};
        if (::poll(numbers.data(), static_cast<nfds_t>(count), 0) < 0) return false;
        free += std::count_if(numbers.begin(), numbers.begin() + count,
                              [](const pollfd& number) { return (number.revents & POLLNVAL) != 0; });
    }
    return false;
}

std::string raise_descriptor_limit() {
    rlimit limit{};
    if (::getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= wanted) return "";
    limit.rlim_cur = std::min(wanted, limit.rlim_max);
    if (::setrlimit(RLIMIT_NOFILE, &limit) != 0)
        return std::string("the limit of open files stays as it is: ") + std::strerror(errno);
    if (limit.rlim_cur >= needed) return "";
    return "at most " + std::to_string(limit.rlim_cur) +
           " open files are allowed, so not all connections that camrig can serve fit; raise the hard limit "
           "(ulimit -Hn, LimitNOFILE=) to " +
           std::to_string(wanted);
}

}  // namespace camrig
