#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>

#include "control/rpc/json_rpc.h"
#include "control/rpc/limits.h"
#include "control/rpc/method.h"
#include "control/server/line_buffer.h"
#include "control/server/loop_event.h"
#include "control/server/loop_post.h"
#include "core/base/thread_check.h"

namespace camrig::control {

class RpcServer;

class Connection;

enum class Transport : std::uint8_t { unix_socket, tcp };

/// What all connections of a server share. Lives on the server's thread and outlives them.
struct ConnectionShared {
    RpcServer& rpc;
    const ControlLimits& limits;
    const std::string& token;
    std::shared_ptr<LoopPost> post;
    std::function<void(Connection*)> on_closed;
    /// A client at this address has shown a wrong token.
    std::function<void(const std::string& peer)> on_wrong_token;
    /// The token was shown; false: there is no place for one more client.
    std::function<bool(Connection*)> on_authorized;
};

/// One client: reads lines, hands them to the RPC server, writes the answers in the order of the requests.
///
/// Thread: the server's. Two coroutines share it, one that reads and one that writes; each keeps it alive. A client is
/// not read while too much is unanswered or unsent, or a message reads files first, and is closed when it takes no byte
/// of an answer for too long.
class Connection : public std::enable_shared_from_this<Connection> {
public:
    using Socket = boost::asio::generic::stream_protocol::socket;

    /// How a client came, what it has to show, and what it may do then.
    struct Access {
        Transport transport = Transport::tcp;
        bool must_show_token = true;
        Authority authority = Authority::look;
        std::string peer = {};  ///< its address, for the log
    };

    Connection(ConnectionShared& shared, Socket socket, Access access);

    void start();
    Transport transport() const { return transport_; }
    bool is_authorized() const { return is_authorized_; }
    /// Since when it has neither asked for anything nor waited for an answer that is due to it; nothing: it is in use.
    std::optional<std::chrono::steady_clock::time_point> idle_since() const {
        return slots_.empty() || !is_authorized_ ? std::optional(last_used_) : std::nullopt;
    }
    /// The peer sends no more: it is gone, or only waits for answers. Asks the system, for the connection does not read
    /// while much is unanswered.
    bool is_ended_by_peer();
    /// Takes no more requests; closes when what was asked is answered and sent.
    void finish();
    void close();

private:
    struct Slot {
        RpcAnswer reply;
        bool is_ready = false;
    };

    boost::asio::awaitable<void> read_loop();
    boost::asio::awaitable<void> write_loop();
    boost::asio::awaitable<bool> write(std::string_view text);
    /// Waits until another request may be started; false when the connection is over.
    boost::asio::awaitable<bool> room();
    /// Reads and discards until the peer ends, or `linger` or `linger_bytes` are over: closing with unread bytes could
    /// destroy the answer.
    boost::asio::awaitable<void> read_off();
    /// True: go on. False: this was the last line that is taken.
    bool take(std::string_view line);
    bool take_first(std::string_view line);
    /// Answers with an error, after this delay, and makes it the last answer of this connection.
    void refuse(int code, ErrorKind kind, std::string message, ControlLimits::Duration after = {});
    /// The message that read files first is started.
    void go_on();
    void answer(const std::shared_ptr<Slot>& slot, RpcAnswer reply);
    void close_after(ControlLimits::Duration time);

    ConnectionShared& shared_;
    Socket socket_;
    LineBuffer lines_;
    std::deque<std::shared_ptr<Slot>> slots_;   ///< requests not yet answered and sent, oldest first
    const std::shared_ptr<ByteBudget> budget_;  ///< of answers that are being made or not sent yet
    std::chrono::steady_clock::time_point last_used_ = std::chrono::steady_clock::now();
    const Transport transport_;
    const Authority authority_;  ///< once it is authorized
    const std::string peer_;
    bool is_authorized_;
    bool is_reading_files_ = false;  ///< for the last message, which is not started yet
    bool is_finishing_ = false;
    bool is_closed_ = false;
    bool reads_off_ = false;
    LoopEvent room_;                   ///< for the reader: a request may be started
    LoopEvent ready_;                  ///< for the writer: an answer may be sent
    boost::asio::steady_timer limit_;  ///< closes the connection when it expires
    boost::asio::steady_timer pause_;  ///< before a refusal is answered
    ThreadCheck thread_;
};

}  // namespace camrig::control
