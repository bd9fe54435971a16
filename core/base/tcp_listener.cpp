#include "core/base/tcp_listener.h"

#include <cerrno>
#include <cstring>
#include <memory>

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

namespace camrig {
namespace {

constexpr const char* localhost = "127.0.0.1";

std::string number_of(const std::string& host) {
    return host == "localhost" ? localhost : host;
}

using Addresses = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

struct Endpoint {
    std::string address;
    std::uint16_t port = 0;
};

Endpoint endpoint_of(const sockaddr* address, socklen_t size) {
    char host[NI_MAXHOST], port[NI_MAXSERV];
    if (::getnameinfo(address, size, host, sizeof host, port, sizeof port, NI_NUMERICHOST | NI_NUMERICSERV) != 0)
        return {};
    return {host, static_cast<std::uint16_t>(std::stoi(port))};
}

Result<Addresses> resolve(const std::string& name, const std::string& host, std::uint16_t port) {
    addrinfo hints{};
    hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* resolved = nullptr;
    const int failed = ::getaddrinfo(number_of(host).c_str(), std::to_string(port).c_str(), &hints, &resolved);
    if (failed != 0)
        return error(ErrorKind::invalid_argument,
                     name + ": host '" + host + "' is not an address of this machine: " + ::gai_strerror(failed));
    return Addresses(resolved, &::freeaddrinfo);
}

}  // namespace

Result<std::string> resolve_address(const char* name, const std::string& host) {
    const auto found = resolve(name, host, 0);
    if (!found) return std::unexpected(found.error());
    return endpoint_of((*found)->ai_addr, (*found)->ai_addrlen).address;
}

Result<TcpListener> listen_tcp(const TcpListenerOptions& options) {
    const std::string name = std::string(options.name) + ": ";
    const auto resolved = resolve(options.name, options.host, options.port);
    if (!resolved) return std::unexpected(resolved.error());
    const Addresses& found = *resolved;
    const std::string asked = endpoint_of(found->ai_addr, found->ai_addrlen).address;
    if (!options.asks_for_token && !is_loopback_address(asked))
        return error(ErrorKind::invalid_argument, name + "host " + options.host +
                                                      " can be reached by others, so it needs a token; give "
                                                      "--token-file, or use --host " +
                                                      localhost);
    const auto cannot = [&] {
        return error(ErrorKind::unavailable, name + "cannot listen on " + asked + " port " +
                                                 std::to_string(options.port) + ": " + std::strerror(errno) +
                                                 "; choose another " + options.port_option + " PORT (0: any free one)");
    };
    TcpListener listener;
    listener.family = found->ai_family;
    listener.fd.reset(::socket(listener.family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const int fd = listener.fd.get(), yes = 1;
    sockaddr_storage own{};
    socklen_t size = sizeof own;
    if (fd < 0 || ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
        ::bind(fd, found->ai_addr, found->ai_addrlen) != 0 || ::listen(fd, SOMAXCONN) != 0 ||
        ::getsockname(fd, reinterpret_cast<sockaddr*>(&own), &size) != 0)
        return cannot();
    Endpoint endpoint = endpoint_of(reinterpret_cast<const sockaddr*>(&own), size);
    listener.address = std::move(endpoint.address);
    listener.port = endpoint.port;
    return listener;
}

bool is_loopback_address(const std::string& host) {
    const std::string number = number_of(host);
    in_addr v4{};
    if (::inet_pton(AF_INET, number.c_str(), &v4) == 1) return (ntohl(v4.s_addr) >> 24) == IN_LOOPBACKNET;
    in6_addr v6{};
    return ::inet_pton(AF_INET6, number.c_str(), &v6) == 1 && IN6_IS_ADDR_LOOPBACK(&v6);
}

bool is_any_address(const std::string& host) {
    in_addr v4{};
    if (::inet_pton(AF_INET, host.c_str(), &v4) == 1) return v4.s_addr == INADDR_ANY;
    in6_addr v6{};
    return ::inet_pton(AF_INET6, host.c_str(), &v6) == 1 && IN6_IS_ADDR_UNSPECIFIED(&v6);
}

}  // namespace camrig
