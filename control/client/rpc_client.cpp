#include "control/client/rpc_client.h"

#include "core/base/json_reader.h"

namespace camrig::client {
namespace {

using nlohmann::json;

camrig::Error error_of(const json& value) {
    camrig::Error error{ErrorKind::internal, "the rig gave an error without words"};
    if (!value.is_object()) return error;
    if (const auto message = value.find("message"); message != value.end() && message->is_string())
        error.message = message->get<std::string>();
    const json kind = value.value("data", json::object());
    if (!kind.is_object() || !kind.contains("kind")) return error;
    for (const ErrorKind one :
         {ErrorKind::invalid_argument, ErrorKind::not_found, ErrorKind::already_exists, ErrorKind::unavailable,
          ErrorKind::unsupported, ErrorKind::resource_exhausted, ErrorKind::unauthorized, ErrorKind::internal})
        if (kind["kind"] == to_string(one)) error.kind = one;
    return error;
}

}  // namespace

Result<RpcClient> RpcClient::connect(const RpcClientOptions& options) {
    const Deadline deadline = std::chrono::steady_clock::now() + options.connect_timeout;
    auto socket = LineSocket::connect(options.endpoint, deadline);
    if (!socket) return std::unexpected(socket.error());
    RpcClient client(std::move(*socket));
    std::string token = options.token;
    if (token.empty() && !options.endpoint.host.empty()) token = client.socket_.command_key().value_or("");
    if (!token.empty() && !options.endpoint.host.empty()) {
        auto authorized = client.call("auth", {{"token", token}}, options.connect_timeout);
        if (!authorized) return std::unexpected(authorized.error());
    }
    return client;
}

Result<json> RpcClient::call(std::string_view method, const json& params, std::chrono::milliseconds timeout) {
    if (is_broken_) return error(ErrorKind::unavailable, "the connection has failed before; connect again");
    const std::int64_t id = next_id_++;
    const json request = {{"jsonrpc", "2.0"}, {"id", id}, {"method", method}, {"params", params}};
    const Deadline deadline = std::chrono::steady_clock::now() + timeout;
    // Until the answer is here the connection cannot be used again: the next answer would be of this call.
    is_broken_ = true;
    const std::string line = request.dump(-1, ' ', false, json::error_handler_t::replace);
    // A rig that refuses us may have answered already, so a failed send is told only if there is no answer either.
    const auto sent = socket_.send(line, deadline);
    auto received = socket_.receive(max_reply_bytes, deadline);
    if (!received) return std::unexpected(sent ? received.error() : sent.error());
    auto reply = parse_json(*received, max_reply_bytes);
    if (!reply || !reply->is_object()) return error(ErrorKind::internal, "the rig's answer is no JSON-RPC");
    if (const auto failed = reply->find("error"); failed != reply->end()) {
        is_broken_ = !reply->contains("id") || (*reply)["id"] != id;
        return std::unexpected(error_of(*failed));
    }
    if (reply->value("id", json()) != id || !reply->contains("result"))
        return error(ErrorKind::internal, "the rig's answer belongs to another request");
    is_broken_ = false;
    return std::move((*reply)["result"]);
}

}  // namespace camrig::client
