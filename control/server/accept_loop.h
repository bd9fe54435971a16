#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <spdlog/spdlog.h>

namespace camrig::control {

/// Out of descriptors: accepting at once again would only burn the processor.
inline constexpr std::chrono::milliseconds accept_pause{100};

/// Gives each connection to `take` until the acceptor is closed, which outlives that; one of which `take` throws is
/// lost. `server` in messages. TCP sends small answers at once, and finds out that a peer has gone.
template <typename Acceptor>
boost::asio::awaitable<void> accept_loop(Acceptor& acceptor, std::string server,
                                         std::function<void(typename Acceptor::protocol_type::socket)> take) {
    using tcp = boost::asio::ip::tcp;
    boost::asio::steady_timer pause(acceptor.get_executor());
    bool must_pause = false;
    while (acceptor.is_open()) {
        // Without memory a connection is lost, never the port.
        try {
            if (std::exchange(must_pause, false)) {
                pause.expires_after(accept_pause);
                co_await pause.async_wait(boost::asio::as_tuple(boost::asio::use_awaitable));
            }
            auto [failed, socket] = co_await acceptor.async_accept(boost::asio::as_tuple(boost::asio::use_awaitable));
            if (!failed) {
                if constexpr (std::is_same_v<Acceptor, tcp::acceptor>) {
                    boost::system::error_code ignored;
                    socket.set_option(tcp::no_delay(true), ignored);
                    socket.set_option(boost::asio::socket_base::keep_alive(true), ignored);
                }
                take(std::move(socket));
            } else if (acceptor.is_open()) {
                must_pause = true;
                spdlog::warn("{}: a connection could not be taken: {}", server, failed.message());
            }
        } catch (const std::exception& thrown) {
            must_pause = true;
            spdlog::warn("{}: a connection could not be taken: {}", server, thrown.what());
        }
    }
}

}  // namespace camrig::control
