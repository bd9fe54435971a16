#include "rtsp_out/http/connection.h"

#include <algorithm>
#include <array>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/http/read.hpp>
#include <spdlog/spdlog.h>

#include "core/base/clock.h"
#include "core/base/token.h"
#include "rtsp_out/http/access.h"
#include "rtsp_out/http/asking_page.h"
#include "rtsp_out/http/send.h"

namespace camrig::http {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Failure = beast::error_code;

namespace {

constexpr auto quiet = asio::as_tuple(asio::use_awaitable);
constexpr std::size_t max_stray_bytes = 64 * 1024;  ///< what a stream's client may send us without meaning

std::string_view view(boost::string_view text) {
    return {text.data(), text.size()};
}

std::optional<std::string_view> field(const auto& message, http::field name) {
    const auto found = message.find(name);
    if (found == message.end()) return std::nullopt;
    return view(found->value());
}

bool is_json(std::string_view content_type) {
    content_type = content_type.substr(0, content_type.find(';'));
    while (content_type.ends_with(' ')) content_type.remove_suffix(1);
    return beast::iequals({content_type.data(), content_type.size()}, "application/json");
}

/// What to answer when a request cannot be read; nothing when nobody is there to hear it.
std::optional<Reply> unreadable(const Failure& failed, bool has_target, std::size_t body_bytes) {
    if (failed == http::error::body_limit)
        return error_reply(413, ErrorKind::resource_exhausted,
                           "the body is larger than " + std::to_string(body_bytes / 1024) + " KiB");
    if ((failed == http::error::header_limit || failed == http::error::buffer_overflow) && !has_target)
        return error_reply(414, ErrorKind::invalid_argument, "the request line is too long");
    if (failed == http::error::header_limit || failed == http::error::buffer_overflow)
        return error_reply(431, ErrorKind::resource_exhausted, "the header fields are larger than 16 KiB");
    if (failed.category() != make_error_code(http::error::bad_method).category() ||
        failed == http::error::end_of_stream || failed == http::error::partial_message)
        return std::nullopt;
    return error_reply(400, ErrorKind::invalid_argument, "this is not an HTTP/1 request: " + failed.message());
}

std::uint16_t local_port_of(const asio::ip::tcp::socket& socket) {
    Failure failed;
    const auto here = socket.local_endpoint(failed);
    return failed ? 0 : here.port();
}

/// Without a port the Host field means port 80, but clients of network cameras leave out others too; and a camera tells
/// its own port, whatever it was called.
std::string with_port(std::string_view host, std::uint16_t port) {
    const std::size_t name_end = host.starts_with('[') ? std::min(host.find(']'), host.size()) : 0;
    std::string full(host);
    if (host.find(':', name_end) == std::string_view::npos) full += ":" + std::to_string(port);
    return full;
}

}  // namespace

std::string describe(const asio::ip::tcp::endpoint& peer) {
    const std::string address = peer.address().to_string();
    return (peer.address().is_v6() ? "[" + address + "]" : address) + ":" + std::to_string(peer.port());
}

HttpConnection::HttpConnection(ServerState& state, asio::ip::tcp::socket socket, asio::ip::tcp::endpoint peer,
                               std::optional<std::string> device)
    : state_(state),
      peer_address_(peer.address()),
      peer_(describe(peer)),
      local_port_(local_port_of(socket)),
      device_(std::move(device)),
      stream_(std::move(socket)),
      buffer_(2 * state.options.limits.header_bytes),
      event_(std::make_shared<AsyncEvent>(stream_.get_executor())) {
    state_.connections.insert(this);
    ++state_.counts.connections.open;
    ++state_.counts.connections.total;
}

HttpConnection::~HttpConnection() {
    close();
}

void HttpConnection::close() {
    if (std::exchange(is_closed_, true)) return;
    end_waiting();
    event_->disconnect();
    stream_.close();
    state_.connections.erase(this);
    --state_.counts.connections.open;
}

void HttpConnection::begin_waiting() {
    waiting_ = state_.waiting.insert(state_.waiting.end(), this);
}

void HttpConnection::end_waiting() {
    if (waiting_) state_.waiting.erase(*waiting_);
    waiting_.reset();
}

asio::awaitable<void> HttpConnection::run() {
    bool again = true;
    while (again && !is_closed_ && !state_.stopping) {
        begin_waiting();
        again = co_await serve_one();
        end_waiting();
    }
    if (is_closed_) co_return;
    begin_waiting();
    co_await linger();
    close();
}

asio::awaitable<bool> HttpConnection::serve_one() {
    Parser parser;
    parser.header_limit(static_cast<std::uint32_t>(state_.options.limits.header_bytes));
    parser.body_limit(body_bytes());
    stream_.expires_after(state_.options.limits.request_time);
    const auto [failed, size] = co_await http::async_read_header(stream_, buffer_, parser, quiet);
    HttpRequest request;
    if (failed) {
        auto refused = unreadable(failed, !parser.get().target().empty(), body_bytes());
        if (!refused) co_return false;
        refused->close = true;
        co_return co_await send(std::move(*refused), request);
    }
    std::optional<Reply> reply = examine(parser.get(), request);
    if (reply && reply->status == 401) co_await hold_back(parser.get(), request);
    const bool body_wanted = !reply && request.route.takes_post && request.method == "POST";
    if (body_wanted) reply = co_await read_body(parser, request);
    if (!reply) end_waiting();
    const bool is_stream = request.route.kind == RouteKind::stream || request.route.kind == RouteKind::live;
    if (!reply && is_stream && request.method == "GET") co_return co_await run_stream(request);
    if (!reply) reply = co_await answer(state_, event_, request);
    if (!parser.is_done()) reply->close = true;  // a body that nobody asked for stays unread
    co_return co_await send(std::move(*reply), request);
}

/// What two programs could read in two ways (RFC 9112 sections 3.2 and 6.1) is refused, and nothing after it is read.
std::optional<Reply> HttpConnection::check_message(const Message& message) const {
    const auto refuse = [](int status, ErrorKind kind, std::string why) {
        Reply reply = error_reply(status, kind, std::move(why));
        reply.close = true;
        return reply;
    };
    const std::size_t encodings = message.count(http::field::transfer_encoding);
    if (encodings > 1 || (encodings == 1 && !beast::iequals(message[http::field::transfer_encoding], "chunked")))
        return refuse(501, ErrorKind::unsupported, "Transfer-Encoding: only chunked is understood");
    const auto host = field(message, http::field::host);
    if (message.count(http::field::host) > 1 || (host && !is_host_field(*host)))
        return refuse(400, ErrorKind::invalid_argument, "Host: must be given once, as a name or address and a port");
    return std::nullopt;
}

std::optional<Reply> HttpConnection::check_access(const Message& message, HttpRequest& request) const {
    const RequestOrigin origin{view(message.method_string()), field(message, http::field::host),
                               field(message, http::field::origin), field(message, http::field::sec_fetch_site)};
    const std::string& token = state_.options.token;
    if (message.version() == 11 && !origin.host)
        return error_reply(400, ErrorKind::invalid_argument, "HTTP/1.1 needs a Host field");
    if (auto good = check_origin(origin, state_.options.host, !token.empty()); !good)
        return error_reply(good.error(), 403);
    const std::string_view given =
        token_of(field(message, http::field::authorization).value_or(""), request.target.find("token"),
                 field(message, http::field::cookie).value_or(""));
    // Looking is open on loopback, so a wrong key (of a rig that was here before, say) is as good as none.
    const std::string& key = state_.options.command_key;
    request.may_command = !token.empty() || key.empty() || equal_tokens(given, key);
    if (token.empty() || equal_tokens(given, token)) return std::nullopt;
    return error_reply(
        {ErrorKind::unauthorized, std::string(given.empty() ? "a token is needed" : "this is not the token") +
                                      ": send 'Authorization: Bearer TOKEN' or add ?token=TOKEN to the URL"});
}

std::optional<Reply> HttpConnection::check_device_access(const Message& message, HttpRequest& request) const {
    const RequestOrigin origin{view(message.method_string()), field(message, http::field::host),
                               field(message, http::field::origin), field(message, http::field::sec_fetch_site)};
    const std::string& token = state_.options.token;
    const auto& hooks = state_.options.hooks.device;
    if (!origin.host) return error_reply(400, ErrorKind::invalid_argument, "a network camera needs a Host field");
    if (auto good = check_origin(origin, state_.options.host, !token.empty()); !good)
        return error_reply(good.error(), 403);
    const std::string_view authorization = field(message, http::field::authorization).value_or("");
    const std::string_view given = token_of(authorization, request.target.find("token"), "");
    auto caller = hooks.caller(origin.method, view(message.target()), authorization,
                               !token.empty() && equal_tokens(given, token));
    request.call.device = *device_;
    request.call.host = with_port(*origin.host, local_port_);
    request.call.port = local_port_;
    request.call.path = request.target.path;
    request.call.rank = caller.rank;
    request.call.shows_wrong = !caller.rank && !caller.is_stale && (!given.empty() || !authorization.empty());
    request.call.challenge = std::move(caller.challenge);
    if (request.call.rank || request.target.path.starts_with("/onvif/")) return std::nullopt;
    Reply refused = error_reply(401, ErrorKind::unauthorized, "a user and password are needed, by HTTP digest");
    refused.fields = {{"WWW-Authenticate", request.call.challenge}};
    return refused;
}

Result<HttpRoute> HttpConnection::find_route(const std::string& path) const {
    if (!device_) return route_of(path);
    auto route = device_route_of(path);
    if (route && !device_->empty() && !route->camera.empty() && route->camera != *device_)
        return error(ErrorKind::not_found, "this port is camera " + *device_);
    return route;
}

std::optional<Reply> HttpConnection::examine(const Message& message, HttpRequest& request) const {
    request.method = std::string(view(message.method_string()));
    request.version = message.version();
    request.keep_alive = message.keep_alive();
    request.if_none_match = std::string(field(message, http::field::if_none_match).value_or(""));
    if (auto refused = check_message(message)) return refused;
    auto target = parse_target(view(message.target()));
    if (!target) return error_reply(target.error(), message.target().size() > max_target_length ? 414 : 400);
    request.target = std::move(*target);
    if (auto refused = device_ ? check_device_access(message, request) : check_access(message, request)) return refused;

    if (request.target.path != "*") {
        auto route = find_route(request.target.path);
        if (!route) return error_reply(route.error());
        request.route = std::move(*route);
    }
    // The page may be linked to from anywhere; what it shows is asked for by itself.
    const AskingPage page{field(message, http::field::host), field(message, http::field::origin),
                          field(message, http::field::referer), field(message, http::field::sec_fetch_site)};
    request.embeds = is_listed_page(page, state_.options.embedders);
    if (request.route.is_guarded && !request.embeds)
        if (auto good = check_page(page); !good) return error_reply(good.error(), 403);
    const std::string allowed = request.route.takes_post ? "POST, OPTIONS" : "GET, HEAD, OPTIONS";
    if (request.method == "OPTIONS") {
        Reply reply;
        reply.status = 204;
        reply.fields.emplace_back("Allow", allowed);
        return reply;
    }
    const bool is_allowed =
        request.route.takes_post ? request.method == "POST" : request.method == "GET" || request.method == "HEAD";
    if (!is_allowed) {
        Reply reply = error_reply(405, ErrorKind::unsupported, request.target.path + " takes " + allowed);
        reply.fields.emplace_back("Allow", allowed);
        return reply;
    }
    if (request.route.kind == RouteKind::rpc && !is_json(field(message, http::field::content_type).value_or("")))
        return error_reply(415, ErrorKind::invalid_argument, "POST /rpc needs 'Content-Type: application/json'");
    if (request.route.kind == RouteKind::stream && request.method == "HEAD") {
        if (const auto params = stream_params(request.target); !params) return error_reply(params.error());
        if (const auto camera = PictureStream::find_open(*state_.options.bus, request.route.camera, peer_); !camera)
            return error_reply(camera.error());
        return PictureStream::head(PictureStream::Form::mjpeg);
    }
    if (request.route.kind == RouteKind::live && request.method == "HEAD") {
        const auto params = live_params(request.target);
        if (!params) return error_reply(params.error());
        for (const std::string& name : params->cameras)
            if (const auto camera = state_.options.bus->find(name); !camera) return error_reply(camera.error());
        return PictureStream::head(PictureStream::Form::live);
    }
    return std::nullopt;
}

asio::awaitable<std::optional<Reply>> HttpConnection::read_body(Parser& parser, HttpRequest& request) {
    if (field(parser.get(), http::field::expect)) {
        static constexpr std::string_view go_on = "HTTP/1.1 100 Continue\r\n\r\n";
        SendPieces pieces{asio::buffer(go_on)};
        const Failure unsent = co_await send_all(stream_, pieces, state_.options.limits.stalled_after);
        if (unsent) co_return error_reply(400, ErrorKind::unavailable, "the client is gone");
    }
    stream_.expires_after(state_.options.limits.request_time);
    const auto [failed, size] = co_await http::async_read(stream_, buffer_, parser, quiet);
    if (failed) {
        auto refused = unreadable(failed, true, body_bytes());
        if (!refused) refused = error_reply(400, ErrorKind::invalid_argument, "the body did not arrive");
        refused->close = true;
        co_return refused;
    }
    request.body = std::move(parser.get().body());
    co_return std::nullopt;
}

Result<std::unique_ptr<PictureStream>> HttpConnection::open_stream(const HttpRequest& request) {
    if (request.route.kind == RouteKind::live) {
        const auto params = live_params(request.target);
        if (!params) return std::unexpected(params.error());
        return PictureStream::open_live(state_, event_, *params, peer_);
    }
    const auto params = stream_params(request.target);
    if (!params) return std::unexpected(params.error());
    return PictureStream::open_mjpeg(state_, event_, request.route.camera, *params, peer_);
}

asio::awaitable<bool> HttpConnection::run_stream(const HttpRequest& request) {
    const auto stream = open_stream(request);
    if (!stream) co_return co_await send(error_reply(stream.error()), request);
    ++state_.counts.requests;
    asio::co_spawn(stream_.get_executor(), watch_peer(),
                   [self = shared_from_this()](std::exception_ptr) { self->close(); });
    co_await (*stream)->run(stream_, request.version, request.embeds);
    co_return false;
}

asio::awaitable<bool> HttpConnection::send(Reply reply, const HttpRequest& request) {
    ++state_.counts.requests;
    if (reply.status >= 400) ++state_.counts.errors;
    reply.embeddable = request.embeds;
    const bool keep_alive = request.keep_alive && !reply.close && !state_.stopping;
    const std::string* token = request.target.find("token");
    if (token && !state_.options.token.empty() && request.route.kind == RouteKind::file && reply.status == 200)
        reply.fields.emplace_back("Set-Cookie",
                                  "camrig_token=" + state_.options.token + "; Path=/; HttpOnly; SameSite=Strict");
    const std::string head = head_of(reply, request.version, keep_alive);
    SendPieces pieces{asio::buffer(head)};
    if (request.method != "HEAD") {
        pieces[1] = asio::buffer(reply.text);
        pieces[2] = asio::buffer(reply.data.data(), reply.data.size());
    }
    Failure failed = co_await send_all(stream_, pieces, state_.options.limits.stalled_after);
    if (request.method == "HEAD") reply.pieces.clear();
    for (auto piece = reply.pieces.begin(); piece != reply.pieces.end() && !failed; ++piece) {
        pieces = {asio::buffer(*piece)};
        failed = co_await send_all(stream_, pieces, state_.options.limits.stalled_after);
        *piece = {};  // large ones go as soon as they can
    }
    co_return keep_alive && !failed;
}

asio::awaitable<void> HttpConnection::hold_back(const Message& message, const HttpRequest& request) {
    const std::string_view authorization = field(message, http::field::authorization).value_or("");
    const std::string_view cookie = field(message, http::field::cookie).value_or("");
    const bool shows_wrong =
        device_ ? request.call.shows_wrong : !token_of(authorization, request.target.find("token"), cookie).empty();
    if (!shows_wrong) co_return;
    ++state_.counts.connections.wrong_tokens;
    if (state_.token_log.due(monotonic_now_ns()))
        spdlog::warn("http: {} has sent a wrong token; {} since the start", peer_,
                     state_.counts.connections.wrong_tokens.load());
    asio::steady_timer pause(stream_.get_executor(), state_.options.limits.wrong_token);
    co_await pause.async_wait(quiet);
}

asio::awaitable<void> HttpConnection::watch_peer() {
    auto& socket = stream_.socket();
    std::array<char, 4096> stray;
    std::size_t total = 0;
    Failure failed;
    socket.non_blocking(true, failed);
    while (!failed && total <= max_stray_bytes) {
        const auto [unready] = co_await socket.async_wait(asio::ip::tcp::socket::wait_read, quiet);
        if (unready) break;
        total += socket.read_some(asio::buffer(stray), failed);
        if (failed == asio::error::would_block) failed.clear();
    }
}

asio::awaitable<void> HttpConnection::linger() {
    Failure failed;
    stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, failed);
    stream_.expires_after(state_.options.limits.linger);
    std::array<char, 4096> unread;
    while (!failed) {
        const auto [ended, size] = co_await stream_.async_read_some(asio::buffer(unread), quiet);
        failed = ended;
    }
}

}  // namespace camrig::http
