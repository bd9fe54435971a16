#include "control/server/control_server.h"

#include <map>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <spdlog/spdlog.h>

#include "control/rpc/json_rpc.h"
#include "control/server/accept_loop.h"
#include "control/server/connection.h"
#include "control/server/loop_thread.h"
#include "core/base/clock.h"
#include "core/base/descriptors.h"
#include "core/base/log_pace.h"
#include "core/base/tcp_listener.h"
#include "core/base/unix_listener.h"

namespace camrig::control {
namespace asio = boost::asio;
using tcp = asio::ip::tcp;
using local = asio::local::stream_protocol;

struct ControlServer::Impl {
    explicit Impl(ControlServerOptions given) : options(std::move(given)) {}

    Result<void> listen_unix();
    Result<void> listen_tcp();
    void take(Connection::Socket socket, Connection::Access access);
    /// Sees to it that `newcomer` (null: one that is not there yet) has a place among those of its transport that have,
    /// or have not, shown the token; closes the one that has been idle longest if it must. False: all are in use.
    bool make_room(Transport transport, bool is_authorized, const Connection* newcomer);
    void refuse(Connection::Socket socket, const Error& why);
    void closed(Connection* connection);
    void count_wrong_token(const std::string& peer);
    void begin_stop();

    const ControlServerOptions options;
    LoopThread thread{"control"};
    asio::io_context& loop = thread.loop();
    UnixListener unix_file;
    local::acceptor unix_acceptor{loop};
    tcp::acceptor tcp_acceptor{loop};
    asio::steady_timer linger{loop};
    std::string tcp_address;
    std::uint16_t tcp_port = 0;
    ConnectionShared shared{*options.rpc,
                            options.limits,
                            options.token,
                            thread.post(),
                            [this](Connection* connection) { closed(connection); },
                            [this](const std::string& peer) { count_wrong_token(peer); },
                            [this](Connection* connection) { return make_room(Transport::tcp, true, connection); }};
    std::map<Connection*, std::shared_ptr<Connection>> connections;
    bool is_stopping = false;
    LiveConnectionCounts counts;
    LogPace token_log, refusal_log;
};

Result<void> ControlServer::Impl::listen_unix() {
    if (options.unix_path.empty()) return {};
    auto listener = UnixListener::listen(options.unix_path);
    if (!listener) return std::unexpected(listener.error());
    unix_file = std::move(*listener);
    boost::system::error_code failed;
    unix_acceptor.assign(local(), unix_file.fd(), failed);
    if (failed) return error(ErrorKind::unavailable, "control socket " + options.unix_path + ": " + failed.message());
    unix_file.release_fd();
    return {};
}

Result<void> ControlServer::Impl::listen_tcp() {
    if (!options.tcp_port) return {};
    auto listener = camrig::listen_tcp({.name = "control over TCP",
                                        .port_option = "--tcp",
                                        .host = options.host,
                                        .port = *options.tcp_port,
                                        .asks_for_token = !options.token.empty()});
    if (!listener) return std::unexpected(listener.error());
    boost::system::error_code failed;
    tcp_acceptor.assign(listener->family == AF_INET ? tcp::v4() : tcp::v6(), listener->fd.get(), failed);
    if (failed) return error(ErrorKind::unavailable, "control over TCP: " + failed.message());
    listener->fd.release();
    tcp_address = std::move(listener->address);
    tcp_port = listener->port;
    return {};
}

void ControlServer::Impl::take(Connection::Socket socket, Connection::Access access) {
    if (is_stopping) return;
    if (access.transport == Transport::tcp && descriptors_are_short())
        return refuse(std::move(socket), {ErrorKind::resource_exhausted, too_many_files});
    if (!make_room(access.transport, !access.must_show_token, nullptr))
        return refuse(std::move(socket),
                      {ErrorKind::resource_exhausted, "there are " + std::to_string(options.limits.connections) +
                                                          " connections in use already; close one"});
    auto connection = std::make_shared<Connection>(shared, std::move(socket), access);
    connections.emplace(connection.get(), connection);
    counts.open = connections.size();
    ++counts.total;
    connection->start();
}

bool ControlServer::Impl::make_room(Transport transport, bool is_authorized, const Connection* newcomer) {
    const std::size_t limit = is_authorized ? options.limits.connections : options.limits.unauthorized_connections;
    std::size_t others = 0;
    Connection* idlest = nullptr;
    const auto each = [&](const auto& use) {
        for (const auto& [key, connection] : connections)
            if (key != newcomer && key->transport() == transport && key->is_authorized() == is_authorized) use(key);
    };
    each([&](Connection* other) {
        ++others;
        const auto since = other->idle_since();
        if (since && (!idlest || *since < *idlest->idle_since())) idlest = other;
    });
    if (others < limit) return true;
    // Or one whose answer nobody may want any more.
    each([&](Connection* other) {
        if (idlest == nullptr && other->is_ended_by_peer()) idlest = other;
    });
    if (!idlest) return false;
    ++counts.displaced;
    idlest->close();
    return true;
}

void ControlServer::Impl::refuse(Connection::Socket socket, const Error& why) {
    ++counts.refused;
    if (refusal_log.due(monotonic_now_ns()))
        spdlog::warn("control: connections are refused, {} since the start: {}", counts.refused.load(), why.message);
    const std::string line = rpc_error({rpc_code::application, why, nullptr}) + "\n";
    boost::system::error_code ignored;
    socket.non_blocking(true, ignored);
    socket.write_some(asio::buffer(line), ignored);  // a fresh socket has room for it
    socket.shutdown(Connection::Socket::shutdown_both, ignored);
}

void ControlServer::Impl::closed(Connection* connection) {
    connections.erase(connection);
    counts.open = connections.size();
    if (is_stopping && connections.empty()) linger.cancel();
}

void ControlServer::Impl::count_wrong_token(const std::string& peer) {
    ++counts.wrong_tokens;
    if (token_log.due(monotonic_now_ns()))
        spdlog::warn("control: {} has sent a wrong token; {} since the start", peer, counts.wrong_tokens.load());
}

void ControlServer::Impl::begin_stop() {
    is_stopping = true;
    boost::system::error_code ignored;
    unix_acceptor.close(ignored);
    tcp_acceptor.close(ignored);
    // Copies: closing takes connections out of the map.
    auto present = connections;
    for (const auto& [key, connection] : present) connection->finish();
    if (connections.empty()) return;
    linger.expires_after(options.limits.linger);
    linger.async_wait([this](boost::system::error_code) {
        auto left = connections;
        for (const auto& [key, connection] : left) connection->close();
    });
}

Result<std::unique_ptr<ControlServer>> ControlServer::create(ControlServerOptions options) {
    CHECK(options.rpc != nullptr);
    auto impl = std::make_unique<Impl>(std::move(options));
    for (auto& listened : {impl->listen_unix(), impl->listen_tcp()})
        if (!listened) return std::unexpected(listened.error());
    Impl& self = *impl;
    if (self.unix_acceptor.is_open()) {
        const Connection::Access access{
            .transport = Transport::unix_socket, .must_show_token = false, .authority = Authority::own};
        const auto take = [&self, access](local::socket socket) { self.take(std::move(socket), access); };
        asio::co_spawn(self.loop, accept_loop(self.unix_acceptor, "control", take), asio::detached);
    }
    if (self.tcp_acceptor.is_open()) {
        const Connection::Access access{.transport = Transport::tcp,
                                        .must_show_token = !self.options.token.empty(),
                                        .authority = self.options.tcp_authority};
        const auto take = [&self, access](tcp::socket socket) {
            boost::system::error_code ignored;
            Connection::Access of_peer = access;
            of_peer.peer = socket.remote_endpoint(ignored).address().to_string();
            self.take(std::move(socket), std::move(of_peer));
        };
        asio::co_spawn(self.loop, accept_loop(self.tcp_acceptor, "control", take), asio::detached);
    }
    self.thread.start();
    return std::unique_ptr<ControlServer>(new ControlServer(std::move(impl)));
}

ControlServer::ControlServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ControlServer::~ControlServer() {
    stop();
}

std::uint16_t ControlServer::tcp_port() const {
    return impl_->tcp_port;
}

std::string ControlServer::tcp_address() const {
    return impl_->tcp_address;
}

ConnectionCounts ControlServer::counts() const {
    return impl_->counts.read();
}

void ControlServer::stop() {
    if (impl_->thread.stop([impl = impl_.get()] { impl->begin_stop(); })) impl_->unix_file.remove_file();
}

}  // namespace camrig::control
