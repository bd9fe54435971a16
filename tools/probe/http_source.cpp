#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include <boost/beast/http/buffer_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include "core/base/clock.h"
#include "core/base/unique_fd.h"
#include "tools/probe/gray.h"
#include "tools/probe/multipart_reader.h"
#include "tools/probe/source.h"

// MJPEG over HTTP, by a plain socket: the probe must see when bytes come, not when a library hands them on.
namespace camrig::probe {
namespace {

namespace http = boost::beast::http;

struct HttpAddress {
    std::string host, port = "80", target = "/";
};

Result<HttpAddress> parse_http_address(const std::string& url) {
    constexpr std::size_t scheme_length = 7;  // http://
    HttpAddress address;
    const std::size_t slash = std::min(url.find('/', scheme_length), url.size());
    std::string authority = url.substr(scheme_length, slash - scheme_length);
    if (slash < url.size()) address.target = url.substr(slash);
    const std::size_t bracket = authority.rfind(']');
    const std::size_t colon = authority.rfind(':');
    if (colon != std::string::npos && (bracket == std::string::npos || colon > bracket)) {
        address.port = authority.substr(colon + 1);
        authority.resize(colon);
    }
    if (authority.starts_with('[') && authority.ends_with(']')) authority = authority.substr(1, authority.size() - 2);
    address.host = authority;
    const bool is_bad = authority.empty() || authority.find('@') != std::string::npos || address.port.empty() ||
                        url.find_first_of(" \r\n\t") != std::string::npos;
    if (is_bad) return error(ErrorKind::invalid_argument, "takes http://HOST[:PORT]/PATH");
    return address;
}

/// Waits until the descriptor is ready; false: the time is over.
bool wait_ready(int fd, short events, TimeNs until_ns) {
    for (;;) {
        const TimeNs left = until_ns - monotonic_now_ns();
        pollfd wait{fd, events, 0};
        const int ready = ::poll(&wait, 1, left <= 0 ? 0 : static_cast<int>((left + ns_per_ms - 1) / ns_per_ms));
        if (ready > 0) return true;
        if (ready == 0 && left <= 0) return false;
    }
}

Result<UniqueFd> connect_to_host(const HttpAddress& address, TimeNs until_ns) {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    if (const int problem = ::getaddrinfo(address.host.c_str(), address.port.c_str(), &hints, &found); problem != 0)
        return error(ErrorKind::not_found, "no host " + address.host + ": " + ::gai_strerror(problem));
    const std::unique_ptr<addrinfo, void (*)(addrinfo*)> all(found, ::freeaddrinfo);
    int why = ETIMEDOUT;
    for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
        UniqueFd fd(::socket(one->ai_family, one->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, one->ai_protocol));
        why = fd && ::connect(fd.get(), one->ai_addr, one->ai_addrlen) == 0 ? 0 : errno;
        if (why == EINPROGRESS) {
            why = ETIMEDOUT;
            socklen_t length = sizeof why;
            if (wait_ready(fd.get(), POLLOUT, until_ns)) ::getsockopt(fd.get(), SOL_SOCKET, SO_ERROR, &why, &length);
        }
        if (why == 0) return fd;
    }
    return error(ErrorKind::unavailable, "cannot connect: " + std::string(std::strerror(why)));
}

class HttpSource final : public Source {
public:
    explicit HttpSource(UniqueFd fd) : fd_(std::move(fd)) { parser_.body_limit(boost::none); }

    Result<void> begin(const HttpAddress& address, const std::string& token, TimeNs until_ns) {
        std::string request = "GET " + address.target + " HTTP/1.1\r\nHost: " + address.host + ":" + address.port +
                              "\r\nAccept: multipart/x-mixed-replace\r\nUser-Agent: camrig-probe\r\n";
        if (!token.empty()) request += "Authorization: Bearer " + token + "\r\n";
        request += "\r\n";
        const ssize_t sent = ::send(fd_.get(), request.data(), request.size(), MSG_NOSIGNAL);
        if (sent != static_cast<ssize_t>(request.size()))  // a part: its buffer is smaller than a request
            return error(ErrorKind::unavailable, std::string("the request was not taken") +
                                                     (sent < 0 ? std::string(": ") + std::strerror(errno) : ""));
        while (!parser_.is_header_done()) {
            const auto more = receive(until_ns);
            if (!more) return std::unexpected(more.error());
            if (!*more) return error(ErrorKind::unavailable, "no answer in time");
        }
        const auto& head = parser_.get();
        if (head.result() != http::status::ok) {
            return error(ErrorKind::unavailable,
                         "the server answers " + std::to_string(head.result_int()) + " " + std::string(head.reason()));
        }
        const auto type = head[http::field::content_type];
        auto reader = MultipartReader::create(std::string_view(type.data(), type.size()));
        if (!reader) return std::unexpected(reader.error());
        reader_ = std::move(*reader);
        reader_->feed(std::exchange(early_body_, {}));
        return {};
    }

    std::string_view kind() const override { return "http"; }
    std::string format() const override { return "MJPEG"; }
    bool stamps_are_monotonic() const override { return has_stamps_; }

    Result<std::optional<ProbedPicture>> next(TimeNs until_ns) override {
        for (;;) {
            auto part = reader_->next();
            if (!part) return std::unexpected(part.error());
            if (*part) return picture_of(std::move(**part));
            if (parser_.is_done()) return error(ErrorKind::unavailable, "the server ended the stream");
            const auto more = receive(until_ns);
            if (!more) return std::unexpected(more.error());
            if (!*more) return std::nullopt;
        }
    }

private:
    std::optional<ProbedPicture> picture_of(BodyPart part) {
        ProbedPicture picture;
        picture.arrival_ns = monotonic_now_ns();
        picture.stamp_ns = part.number("x-monotonic-ns");
        has_stamps_ |= picture.stamp_ns.has_value();
        picture.sequence = part.number("x-sequence");
        jpeg_ = std::move(part.bytes);
        picture.damaged = !gray_from_jpeg(std::as_bytes(std::span(jpeg_)), picture.size, gray_);
        if (!picture.damaged) picture.gray = gray_;
        return picture;
    }

    /// Takes what came in; false: nothing until then.
    Result<bool> receive(TimeNs until_ns) {
        if (!wait_ready(fd_.get(), POLLIN, until_ns)) return false;
        const ssize_t got = ::recv(fd_.get(), incoming_.data() + kept_, incoming_.size() - kept_, 0);
        if (got < 0 && (errno == EAGAIN || errno == EINTR)) return true;
        if (got < 0) return error(ErrorKind::unavailable, std::string("the connection broke: ") + std::strerror(errno));
        if (got == 0) return error(ErrorKind::unavailable, "the server closed the connection");
        return parse(kept_ + static_cast<std::size_t>(got));
    }

    Result<bool> parse(std::size_t size) {
        std::size_t used = 0;
        while (used < size) {
            std::array<char, 65536> body;
            if (parser_.is_header_done()) {
                parser_.get().body().data = body.data();
                parser_.get().body().size = body.size();
                parser_.get().body().more = true;
            }
            boost::system::error_code problem;
            const std::size_t taken = parser_.put(boost::asio::buffer(incoming_.data() + used, size - used), problem);
            used += taken;
            if (parser_.is_header_done() && parser_.get().body().data != nullptr) {
                const std::string_view bytes(body.data(), body.size() - parser_.get().body().size);
                reader_ ? reader_->feed(bytes) : void(early_body_ += bytes);
                parser_.get().body().data = nullptr;
            }
            if (problem == http::error::need_more) break;
            if (problem && problem != http::error::need_buffer)
                return error(ErrorKind::unavailable, "is not HTTP: " + problem.message());
            if (parser_.is_done() || (taken == 0 && !problem)) break;
        }
        kept_ = size - used;
        if (kept_ == incoming_.size()) return error(ErrorKind::unavailable, "an HTTP header without an end");
        std::memmove(incoming_.data(), incoming_.data() + used, kept_);
        return true;
    }

    const UniqueFd fd_;
    http::response_parser<http::buffer_body> parser_;
    std::optional<MultipartReader> reader_;
    std::string early_body_;  ///< what came with the header, before there was a reader
    std::array<char, 65536> incoming_{};
    std::size_t kept_ = 0;     ///< bytes of incoming_ that the parser wants again with more behind them
    bool has_stamps_ = false;  ///< other servers' streams have none
    std::string jpeg_;
    std::vector<std::byte> gray_;
};

}  // namespace

Result<std::unique_ptr<Source>> open_http_source(const std::string& url, const SourceOptions& options) {
    const TimeNs until_ns = monotonic_now_ns() + options.timeout_ns;
    const auto address = parse_http_address(url);
    if (!address) return std::unexpected(address.error());
    auto fd = connect_to_host(*address, until_ns);
    if (!fd) return std::unexpected(fd.error());
    auto source = std::make_unique<HttpSource>(std::move(*fd));
    if (auto begun = source->begin(*address, options.token, until_ns); !begun) return std::unexpected(begun.error());
    return source;
}

}  // namespace camrig::probe
