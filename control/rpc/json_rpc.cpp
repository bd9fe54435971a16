#include "control/rpc/json_rpc.h"

#include <algorithm>
#include <iterator>

#include "core/base/json_reader.h"

namespace camrig::control {
namespace {

using nlohmann::json;

/// Pieces of an answer up to so many bytes become one: fewer writes.
constexpr std::size_t small_piece_bytes = 64 * 1024;

RpcError invalid_request(std::string message, json id = nullptr) {
    return {rpc_code::invalid_request, {ErrorKind::invalid_argument, std::move(message)}, std::move(id)};
}

bool is_id(const json& value) {
    return value.is_null() || value.is_string() || value.is_number();
}

std::variant<RpcRequest, RpcError> parse_one(json& value) {
    if (!value.is_object())
        return invalid_request(R"(a request is an object: {"jsonrpc":"2.0","id":1,"method":"world.status"})");
    RpcRequest request;
    if (const auto id = value.find("id"); id != value.end()) {
        if (!is_id(*id)) return invalid_request("id: must be a string, a number or null");
        request.id = *id;
    }
    const json id = request.id.value_or(nullptr);
    if (const auto version = value.find("jsonrpc"); version == value.end() || *version != "2.0")
        return invalid_request("jsonrpc: must be \"2.0\"", id);
    const auto method = value.find("method");
    if (method == value.end() || !method->is_string()) return invalid_request("method: must be a string", id);
    request.method = method->get<std::string>();
    for (const auto& [key, item] : value.items()) {
        if (key != "jsonrpc" && key != "id" && key != "method" && key != "params")
            return invalid_request(
                "unknown member '" + key.substr(0, 60) + "'; a request has jsonrpc, id, method and params", id);
    }
    if (const auto params = value.find("params"); params != value.end()) {
        if (!params->is_object()) {
            const std::string hint = R"(params: must be an object like {"name":"lobby"}; parameters go by name)";
            return RpcError{rpc_code::invalid_params, {ErrorKind::invalid_argument, hint}, id, !request.id.has_value()};
        }
        request.params = std::move(*params);
    }
    return request;
}

/// Bytes that are no UTF-8 become U+FFFD: an answer always goes out.
std::string dump(const json& value) {
    return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace

RpcMessage parse_rpc(std::string_view text) {
    RpcMessage message;
    auto value = parse_json(text, max_request_bytes);
    if (!value) {
        message.items.emplace_back(RpcError{rpc_code::parse_error, value.error(), nullptr});
        return message;
    }
    if (!value->is_array()) {
        message.items.push_back(parse_one(*value));
        return message;
    }
    if (value->empty()) {
        message.items.emplace_back(invalid_request("the batch is empty"));
        return message;
    }
    if (value->size() > max_batch) {
        message.items.emplace_back(invalid_request("the batch has " + std::to_string(value->size()) +
                                                   " requests; at most " + std::to_string(max_batch) + " are taken"));
        return message;
    }
    message.is_batch = true;
    for (auto& item : *value) message.items.push_back(parse_one(item));
    return message;
}

void RpcAnswer::append(std::string text) {
    if (!pieces.empty() && pieces.back().size() + text.size() <= small_piece_bytes) {
        pieces.back() += text;
    } else {
        pieces.push_back(std::move(text));
    }
}

void RpcAnswer::append(RpcAnswer answer) {
    for (auto& piece : answer.pieces) append(std::move(piece));
    std::ranges::move(answer.claims, std::back_inserter(claims));
}

std::size_t RpcAnswer::size() const {
    std::size_t bytes = 0;
    for (const auto& piece : pieces) bytes += piece.size();
    return bytes;
}

std::string RpcAnswer::joined() const {
    std::string text;
    text.reserve(size());
    for (const auto& piece : pieces) text += piece;
    return text;
}

RpcAnswer rpc_result(const json& id, RpcResult result) {
    RpcAnswer answer;
    std::string head = R"({"jsonrpc":"2.0","id":)" + dump(id) + R"(,"result":)" + dump(result.fields);
    if (result.is_bytes) {
        answer.after_line = std::move(result.data);
    } else if (!result.data.empty()) {
        CHECK(result.fields.is_object() && !result.fields.empty());
        head.pop_back();
        answer.append(std::move(head) + ",\"data\":\"");
        answer.append(std::move(result.data));
        head = "\"}";
    }
    answer.append(std::move(head) + "}");
    if (result.claim) answer.claims.push_back(std::move(*result.claim));
    return answer;
}

std::string rpc_error(const RpcError& error) {
    return dump(json{{"jsonrpc", "2.0"},
                     {"id", error.id},
                     {"error",
                      {{"code", error.code},
                       {"message", error.error.message},
                       {"data", {{"kind", std::string(to_string(error.error.kind))}}}}}});
}

int rpc_code_of(ErrorKind kind) {
    return kind == ErrorKind::invalid_argument ? rpc_code::invalid_params : rpc_code::application;
}

}  // namespace camrig::control
