#include "control/unrealcv/unrealcv_server.h"

#include <map>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <spdlog/spdlog.h>

#include "control/server/accept_loop.h"
#include "control/server/loop_thread.h"
#include "control/unrealcv/client_connection.h"
#include "core/base/clock.h"
#include "core/base/descriptors.h"
#include "core/base/log_pace.h"
#include "core/base/tcp_listener.h"

namespace camrig::unrealcv {
namespace asio = boost::asio;
using tcp = asio::ip::tcp;

namespace {

constexpr std::size_t max_jobs = 64;

}  // namespace

struct UnrealCvServer::Impl {
    Impl(engine::CommandPort& commands, stream::FrameFetcher& frames, UnrealCvOptions given)
        : options(std::move(given)), door{.commands = commands, .frames = frames} {
        door.folder = options.folder;
        door.depth = options.depth;
        door.post = thread.post();
        door.workers = std::make_shared<stream::WorkerPool>(1, max_jobs);
        door.budget =
            ByteBudget::create(options.limits.picture_bytes,
                               "too many pictures are being made for UnrealCV's clients; ask for less at once");
    }

    Result<void> listen();
    void take(tcp::socket socket);
    void begin_stop();

    const UnrealCvOptions options;
    control::LoopThread thread{"unrealcv"};
    asio::io_context& loop = thread.loop();
    tcp::acceptor acceptor{loop};
    DoorState door;
    std::map<ClientConnection*, std::shared_ptr<ClientConnection>> connections;
    LiveConnectionCounts counts;
    LogPace refusal_log;
    bool is_stopping = false;
};

Result<void> UnrealCvServer::Impl::listen() {
    if (!is_loopback_address(options.host))
        return error(ErrorKind::invalid_argument,
                     "--unrealcv: " + options.host +
                         " can be reached by others, and UnrealCV's protocol asks nobody for a password; it listens on "
                         "loopback only");
    auto listener =
        listen_tcp({.name = "unrealcv", .port_option = "--unrealcv", .host = options.host, .port = options.port});
    if (!listener) return std::unexpected(listener.error());
    boost::system::error_code failed;
    acceptor.assign(listener->family == AF_INET ? tcp::v4() : tcp::v6(), listener->fd.get(), failed);
    if (failed) return error(ErrorKind::unavailable, "unrealcv: " + failed.message());
    listener->fd.release();
    door.port = listener->port;
    return {};
}

void UnrealCvServer::Impl::take(tcp::socket socket) {
    if (is_stopping) return;
    if (connections.size() >= options.limits.connections || descriptors_are_short()) {
        ++counts.refused;
        // A client that is not greeted waits for ever; one that is closed reports it.
        if (refusal_log.due(monotonic_now_ns()))
            spdlog::warn("unrealcv: connections are refused, {} since the start: {} are in use", counts.refused.load(),
                         connections.size());
        return;
    }
    auto connection =
        std::make_shared<ClientConnection>(door, options.limits, std::move(socket), [this](ClientConnection* closed) {
            connections.erase(closed);
            counts.open = connections.size();
        });
    connections.emplace(connection.get(), connection);
    counts.open = connections.size();
    ++counts.total;
    connection->start("connected to " + (options.name.empty() ? "camrig" : options.name));
}

void UnrealCvServer::Impl::begin_stop() {
    is_stopping = true;
    boost::system::error_code ignored;
    acceptor.close(ignored);
    const auto present = connections;  // closing takes connections out of the map
    for (const auto& [key, connection] : present) connection->close();
}

Result<std::unique_ptr<UnrealCvServer>> UnrealCvServer::create(engine::CommandPort& commands,
                                                               stream::FrameFetcher& frames, UnrealCvOptions options) {
    if (!options.folder.empty()) {
        std::error_code failed;
        options.folder = std::filesystem::absolute(options.folder, failed);
        if (failed || !std::filesystem::is_directory(options.folder, failed))
            return error(ErrorKind::invalid_argument,
                         "--unrealcv-dir " + options.folder.string() + ": is no folder; make it first");
    }
    auto impl = std::make_unique<Impl>(commands, frames, std::move(options));
    if (auto listening = impl->listen(); !listening) return std::unexpected(listening.error());
    Impl& self = *impl;
    const auto take = [&self](tcp::socket socket) { self.take(std::move(socket)); };
    asio::co_spawn(self.loop, control::accept_loop(self.acceptor, "unrealcv", take), asio::detached);
    self.thread.start();
    return std::unique_ptr<UnrealCvServer>(new UnrealCvServer(std::move(impl)));
}

UnrealCvServer::UnrealCvServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
UnrealCvServer::~UnrealCvServer() {
    stop();
}

std::uint16_t UnrealCvServer::port() const {
    return impl_->door.port;
}

ConnectionCounts UnrealCvServer::counts() const {
    return impl_->counts.read();
}

void UnrealCvServer::stop() {
    if (impl_->thread.stop([impl = impl_.get()] { impl->begin_stop(); })) impl_->door.workers->stop();
}

}  // namespace camrig::unrealcv
