#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/base/time.h"

namespace camrig::rtsp {

/// Limits on what a client may send. A request of a stock client is a few hundred bytes in some ten lines.
struct RequestLimits {
    std::size_t line_bytes = 2048;
    std::size_t head_bytes = 8192;  ///< request line and header lines, with empty lines before them
    std::size_t header_lines = 64;
    std::size_t body_bytes = 16 * 1024;
    std::size_t data_bytes = 8192;  ///< one interleaved packet (RTCP: some hundred bytes)
    int messages_per_s = 100;
};

/// Checks one client's bytes (RFC 2326 requests and interleaved packets) against RequestLimits and the grammar.
///
/// The RTSP library reads the same bytes after it. What the library could understand in another way is refused, so that
/// both always agree on where a message ends: lines that end in anything but CR LF, folded lines, control characters, a
/// Content-Length that is no plain number or comes twice, answers, and HTTP (tunnels are not offered). Plain
/// arithmetic; holds at most one line.
class RequestBounds {
public:
    explicit RequestBounds(const RequestLimits& limits = {}) : limits_(limits) {}

    /// Checks the next bytes. invalid_argument: names the limit or rule that is broken; not to be called afterwards.
    Result<void> take(std::string_view bytes, TimeNs monotonic_ns);
    /// From now on the client may send interleaved packets: a stream over its connection has been set up.
    void allow_data() { may_send_data_ = true; }
    /// When the first byte of a message came that is not complete yet; 0: there is none.
    TimeNs message_began_ns() const { return began_ns_; }

private:
    enum class State { between, data_head, line, line_end, body };

    Result<void> take_byte(char byte, TimeNs now_ns);
    Result<void> begin(char byte, TimeNs now_ns);
    Result<void> end_line();
    Result<void> check_request_line() const;
    Result<void> read_field();
    void end_message();

    RequestLimits limits_;
    State state_ = State::between;
    std::string line_;
    std::size_t lines_ = 0;
    std::size_t head_bytes_ = 0;
    std::size_t left_ = 0;  ///< of a body or a packet, or of a packet's head
    std::size_t body_bytes_ = 0;
    bool has_length_ = false;
    bool may_send_data_ = false;
    TimeNs began_ns_ = 0;
    TimeNs second_began_ns_ = 0;
    int messages_in_second_ = 0;
};

}  // namespace camrig::rtsp
