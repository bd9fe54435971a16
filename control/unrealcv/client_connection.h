#pragma once

#include <array>
#include <deque>
#include <functional>
#include <memory>
#include <string>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

#include "control/server/loop_event.h"
#include "control/unrealcv/session.h"
#include "control/unrealcv/unrealcv_server.h"
#include "control/unrealcv/wire.h"

namespace camrig::unrealcv {

/// One client: reads its requests, answers them one after the other, in their order.
///
/// Thread: the door's. Two coroutines share it, one that reads and one that answers; each keeps it alive. A client is
/// not read while too much of it waits, and is closed when it takes no byte of an answer for too long.
class ClientConnection : public std::enable_shared_from_this<ClientConnection> {
public:
    using Socket = boost::asio::ip::tcp::socket;

    ClientConnection(DoorState& door, const UnrealCvLimits& limits, Socket socket,
                     std::function<void(ClientConnection*)> on_closed);
    /// Greets the client and serves it.
    void start(const std::string& greeting);
    void close();

private:
    boost::asio::awaitable<void> read_loop();
    boost::asio::awaitable<void> serve_loop(std::string greeting);
    boost::asio::awaitable<bool> write(std::string_view head, std::string_view body);
    void close_after(UnrealCvLimits::Duration time);
    void break_off(const std::string& why);

    DoorState& door_;
    const UnrealCvLimits& limits_;
    Socket socket_;
    const std::function<void(ClientConnection*)> on_closed_;
    const std::shared_ptr<Session> session_;
    FrameReader frames_;
    std::deque<std::string> waiting_;  ///< requests, oldest first
    std::size_t waiting_bytes_ = 0;
    bool is_at_end_ = false;  ///< the client sends no more
    bool is_closed_ = false;
    control::LoopEvent room_;          ///< for the reader: less is waiting
    control::LoopEvent ready_;         ///< for who answers: a request is there, or the end
    boost::asio::steady_timer limit_;  ///< closes the connection when it expires
};

}  // namespace camrig::unrealcv
