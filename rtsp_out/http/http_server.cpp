#include "rtsp_out/http/http_server.h"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <string_view>
#include <thread>
#include <utility>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <netinet/tcp.h>
#include <pthread.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include "core/base/clock.h"
#include "core/base/descriptors.h"
#include "core/base/tcp_listener.h"
#include "core/base/token.h"
#include "rtsp_out/http/access.h"
#include "rtsp_out/http/connection.h"
#include "rtsp_out/http/server_state.h"

namespace camrig::http {

namespace asio = boost::asio;
using asio::ip::tcp;
using Failure = boost::system::error_code;

namespace {

constexpr auto quiet = asio::as_tuple(asio::use_awaitable);
/// Pause after accept() failed for lack of file descriptors or memory; others may give some back.
constexpr std::chrono::milliseconds accept_pause{100};

/// Pictures go out at once, and no more of them waits in the kernel than the peer is about to take.
void tune(tcp::socket& socket, const HttpLimits& limits) {
    Failure ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    socket.set_option(asio::socket_base::send_buffer_size(limits.send_buffer_bytes), ignored);
    ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &limits.unsent_bytes,
                 sizeof limits.unsent_bytes);
}

/// False when something threw (memory ran out): what it was about is lost, everything else goes on.
bool run_until_thrown(asio::io_context& io) {
    try {
        io.run();
        return true;
    } catch (const std::exception& thrown) {
        spdlog::error("http: {}", thrown.what());
        return false;
    }
}

}  // namespace

struct HttpServer::Impl final : stream::CameraObserver {
    explicit Impl(HttpOptions options) : state(std::move(options)) {}

    void camera_added(const stream::CameraStream&) override {}
    void camera_changed(const stream::CameraStream&) override {
        ++state.camera_changes;
        asio::post(io, [this] {
            for (HttpConnection* connection : state.connections) connection->wake();
        });
    }
    void camera_removed(const stream::CameraStream&) override {}

    /// A port that is listened on: the rig's, or one of a network camera.
    struct Door {
        tcp::acceptor acceptor;
        asio::steady_timer pause;
        std::optional<std::string> device;
        std::string address = {};
        std::uint16_t port = 0;
    };
    using DoorRef = std::shared_ptr<Door>;

    Result<DoorRef> listen(std::uint16_t wanted, const char* port_option, std::optional<std::string> device);
    asio::awaitable<void> accept_all(DoorRef door);
    void report_untaken(std::string_view why);
    void admit(tcp::socket socket, const std::optional<std::string>& device);
    Result<std::uint16_t> open_device_port(std::string device, std::uint16_t wanted);
    bool close_device_port(const std::string& device, std::uint16_t closed);
    /// Sees to it that there is a place for one more; closes the one that has waited longest for a request if it must,
    /// of this peer where it has as many as it may.
    bool make_room(const asio::ip::address& peer);
    void refuse(tcp::socket socket, const Error& why);
    void shut_down();

    ServerState state;
    asio::io_context io{1};      // after state: connections that die with it use the state
    std::vector<DoorRef> doors;  ///< the rig's is the first
    std::string address;
    std::uint16_t port = 0;
    std::once_flag stopped;
    std::thread thread;
};

Result<HttpServer::Impl::DoorRef> HttpServer::Impl::listen(std::uint16_t wanted, const char* port_option,
                                                           std::optional<std::string> device) {
    const HttpOptions& options = state.options;
    if (!options.token.empty())
        if (auto good = check_token(options.token); !good) return std::unexpected(good.error());
    auto listener = listen_tcp({.name = device ? "onvif" : "http",
                                .port_option = port_option,
                                .host = address.empty() ? options.host : address,  // a name is looked up once
                                .port = wanted,
                                .asks_for_token = !options.token.empty()});
    if (!listener) return std::unexpected(listener.error());
    auto door = std::make_shared<Door>(
        Door{.acceptor = tcp::acceptor(io), .pause = asio::steady_timer(io), .device = std::move(device)});
    Failure failed;
    door->acceptor.assign(listener->family == AF_INET ? tcp::v4() : tcp::v6(), listener->fd.get(), failed);
    if (failed) return error(ErrorKind::unavailable, "http: " + failed.message());
    listener->fd.release();
    door->address = std::move(listener->address);
    door->port = listener->port;
    doors.push_back(door);
    asio::co_spawn(io, accept_all(door), asio::detached);
    return door;
}

Result<std::uint16_t> HttpServer::Impl::open_device_port(std::string device, std::uint16_t wanted) {
    if (state.stopping) return error(ErrorKind::unavailable, "http: the server ends");
    const char* const port_option = device.empty() ? "--onvif" : "another port of the output";
    auto door = listen(wanted, port_option, std::move(device));
    if (!door) return std::unexpected(door.error());
    return (*door)->port;
}

bool HttpServer::Impl::close_device_port(const std::string& device, std::uint16_t closed) {
    const auto count = std::erase_if(doors, [&](const DoorRef& door) {
        if (door->device != device || door->port != closed) return false;
        Failure ignored;
        door->acceptor.close(ignored);
        door->pause.cancel();
        return true;
    });
    return count > 0;
}

asio::awaitable<void> HttpServer::Impl::accept_all(DoorRef door) {
    bool must_pause = false;
    while (!state.stopping && door->acceptor.is_open()) {
        // Without memory a connection is lost, never the port.
        try {
            if (std::exchange(must_pause, false)) {
                door->pause.expires_after(accept_pause);
                co_await door->pause.async_wait(quiet);
            }
            auto [failed, socket] = co_await door->acceptor.async_accept(quiet);
            if (state.stopping || failed == asio::error::operation_aborted) co_return;
            if (!failed) {
                admit(std::move(socket), door->device);
                continue;
            }
            must_pause = true;
            report_untaken(failed.message());
        } catch (const std::exception& thrown) {
            must_pause = true;
            report_untaken(thrown.what());
        }
    }
}

void HttpServer::Impl::report_untaken(std::string_view why) {
    if (state.accept_log.due(monotonic_now_ns())) spdlog::warn("http: a connection could not be taken: {}", why);
}

void HttpServer::Impl::admit(tcp::socket socket, const std::optional<std::string>& device) {
    Failure failed;
    const auto peer = socket.remote_endpoint(failed);
    if (failed) return;  // gone already
    if (descriptors_are_short()) return refuse(std::move(socket), {ErrorKind::unavailable, too_many_files});
    if (!make_room(peer.address()))
        return refuse(std::move(socket),
                      {ErrorKind::resource_exhausted, "too many connections; close some and try again"});
    tune(socket, state.options.limits);
    auto connection = std::make_shared<HttpConnection>(state, std::move(socket), peer, device);
    asio::co_spawn(io, connection->run(), [connection](std::exception_ptr thrown) {
        if (!thrown) return;
        connection->close();
        try {
            std::rethrow_exception(thrown);
        } catch (const std::exception& what) {
            spdlog::error("http: a connection failed: {}", what.what());
        } catch (...) {
            spdlog::error("http: a connection failed");
        }
    });
}

bool HttpServer::Impl::make_room(const asio::ip::address& peer) {
    const HttpLimits& limits = state.options.limits;
    const auto of_peer =
        static_cast<std::size_t>(std::ranges::count(state.connections, peer, &HttpConnection::peer_address));
    const bool is_peer_full =
        of_peer >= (peer.is_loopback() ? limits.connections_per_local_peer : limits.connections_per_peer);
    if (!is_peer_full && state.connections.size() < limits.connections &&
        state.waiting.size() < limits.waiting_connections)
        return true;
    const auto longest = std::ranges::find_if(
        state.waiting, [&](const HttpConnection* one) { return !is_peer_full || one->peer_address() == peer; });
    if (longest == state.waiting.end()) return false;
    ++state.counts.connections.displaced;
    (*longest)->close();
    return true;
}

void HttpServer::Impl::refuse(tcp::socket socket, const Error& why) {
    ++state.counts.connections.refused;
    if (state.accept_log.due(monotonic_now_ns()))
        spdlog::warn("http: connections are refused, {} since the start: {}", state.counts.connections.refused.load(),
                     why.message);
    Failure ignored;
    socket.non_blocking(true, ignored);
    const Reply reply = error_reply(why);
    const std::string text = head_of(reply, 11, false) + reply.text;
    socket.write_some(asio::buffer(text), ignored);
    socket.shutdown(tcp::socket::shutdown_send, ignored);
}

void HttpServer::Impl::shut_down() {
    state.stopping = true;
    Failure ignored;
    for (const DoorRef& door : doors) {
        door->acceptor.close(ignored);
        door->pause.cancel();
    }
    const auto present = state.connections;  // closing takes them out of the set
    for (HttpConnection* connection : present) connection->close();
}

HttpServer::HttpServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
HttpServer::~HttpServer() {
    stop();
}

Result<std::unique_ptr<HttpServer>> HttpServer::create(HttpOptions options) {
    CHECK(options.bus != nullptr && options.fetcher != nullptr);
    try {
        auto impl = std::make_unique<Impl>(std::move(options));
        auto door = impl->listen(impl->state.options.port, "--http", std::nullopt);
        if (!door) return std::unexpected(door.error());
        impl->address = (*door)->address;
        impl->port = (*door)->port;
        impl->thread = std::thread([io = &impl->io] {
            ::pthread_setname_np(::pthread_self(), "camrig-http");
            while (!run_until_thrown(*io)) continue;
        });
        impl->state.options.bus->add_observer(impl.get());
        return std::unique_ptr<HttpServer>(new HttpServer(std::move(impl)));
    } catch (const std::exception& thrown) {
        return error(ErrorKind::unavailable, std::string("http: cannot start: ") + thrown.what());
    }
}

std::uint16_t HttpServer::port() const {
    return impl_->port;
}
std::string HttpServer::address() const {
    return impl_->address;
}
HttpCounts HttpServer::counts() const {
    return impl_->state.counts.read();
}

void HttpServer::open_device_port(std::string device, std::uint16_t port,
                                  std::function<void(Result<std::uint16_t>)> done) {
    const auto& hooks = impl_->state.options.hooks.device;
    CHECK(hooks.caller && hooks.call);
    asio::post(impl_->io, [impl = impl_.get(), device = std::move(device), port, done = std::move(done)]() mutable {
        done(impl->open_device_port(std::move(device), port));
    });
}

void HttpServer::close_device_port(std::string device, std::uint16_t port, std::function<void(bool)> done) {
    asio::post(impl_->io, [impl = impl_.get(), device = std::move(device), port, done = std::move(done)] {
        done(impl->close_device_port(device, port));
    });
}

void HttpServer::stop() {
    std::call_once(impl_->stopped, [this] {
        impl_->state.options.bus->remove_observer(impl_.get());
        asio::post(impl_->io, [impl = impl_.get()] { impl->shut_down(); });
        impl_->thread.join();
    });
}

}  // namespace camrig::http
