#include "rtsp_out/http/send.h"

#include <algorithm>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace camrig::http {

namespace asio = boost::asio;
namespace beast = boost::beast;

asio::awaitable<beast::error_code> send_all(beast::tcp_stream& stream, SendPieces pieces,
                                            std::chrono::nanoseconds stalled_after) {
    while (asio::buffer_size(pieces) > 0) {
        stream.expires_after(stalled_after);
        auto [failed, sent] = co_await stream.async_write_some(pieces, asio::as_tuple(asio::use_awaitable));
        if (failed) co_return failed;
        for (auto& piece : pieces) {
            const std::size_t part = std::min(sent, piece.size());
            piece += part;
            sent -= part;
        }
    }
    co_return beast::error_code{};
}

}  // namespace camrig::http
