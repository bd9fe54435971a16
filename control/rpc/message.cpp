#include "control/rpc/message.h"

#include "core/base/json_reader.h"

namespace camrig {
namespace {

using nlohmann::json;

std::string dump(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

std::unexpected<BadRequest> bad(json id, int code, std::string message, ErrorKind kind = ErrorKind::invalid_argument) {
    return std::unexpected(BadRequest{std::move(id), {code, {kind, std::move(message)}}});
}

std::expected<RpcRequest, BadRequest> decode_request(json value) {
    const auto invalid = [](json id, std::string message) {
        return bad(std::move(id), rpc_code::invalid_request, std::move(message));
    };
    if (!value.is_object())
        return invalid(nullptr, R"(a request is an object: {"jsonrpc":"2.0","id":1,"method":"world.status"})");
    RpcRequest request;
    const auto id = value.find("id");
    request.is_notification = id == value.end();
    if (!request.is_notification) {
        if (!id->is_string() && !id->is_number() && !id->is_null())
            return invalid(nullptr, "id: must be a string, a number or null");
        request.id = *id;
    }
    const auto version = value.find("jsonrpc");
    if (version == value.end() || *version != "2.0") return invalid(request.id, R"(jsonrpc: must be "2.0")");
    const auto method = value.find("method");
    if (method == value.end() || !method->is_string())
        return invalid(request.id, "method: must be the name of a method; server.info lists them");
    request.method = method->get<std::string>();
    for (const auto& [key, ignored] : value.items()) {
        if (key != "jsonrpc" && key != "method" && key != "params" && key != "id")
            return invalid(request.id, key.substr(0, 60) + ": a request has only jsonrpc, id, method and params");
    }
    if (const auto params = value.find("params"); params != value.end()) {
        if (params->is_array()) {
            return bad(request.id, rpc_code::invalid_params,
                       R"(params: parameters go by name: an object like {"name":"lobby"}, not an array)");
        }
        if (!params->is_object()) return invalid(request.id, "params: must be an object");
        request.params = std::move(*params);
    }
    return request;
}

}  // namespace

RpcError rpc_error(Error error) {
    const int code = error.kind == ErrorKind::invalid_argument ? rpc_code::invalid_params : rpc_code::failed;
    return {code, std::move(error)};
}

RpcMessage decode_message(std::string_view text, const ControlLimits& limits) {
    RpcMessage message;
    auto parsed = parse_json(text, limits.line_bytes);
    if (!parsed) {
        message.items.push_back(bad(nullptr, rpc_code::parse_error, parsed.error().message, parsed.error().kind));
        return message;
    }
    if (!parsed->is_array()) {
        message.items.push_back(decode_request(std::move(*parsed)));
        return message;
    }
    if (parsed->empty()) {
        message.items.push_back(bad(nullptr, rpc_code::invalid_request, "a batch holds at least one request"));
    } else if (parsed->size() > limits.batch) {
        message.items.push_back(bad(nullptr, rpc_code::invalid_request,
                                    "a batch of " + std::to_string(parsed->size()) + " requests; at most " +
                                        std::to_string(limits.batch) + " are taken",
                                    ErrorKind::resource_exhausted));
    } else {
        message.is_batch = true;
        for (json& item : *parsed) message.items.push_back(decode_request(std::move(item)));
    }
    return message;
}

std::string encode_result(const json& id, const RpcResult& result) {
    std::string fields = dump(result.fields);
    if (!result.data.empty()) {
        CHECK(result.fields.is_object() && !result.fields.empty());
        fields.pop_back();
        fields += ",\"data\":\"" + result.data + "\"}";
    }
    return R"({"jsonrpc":"2.0","id":)" + dump(id) + R"(,"result":)" + std::move(fields) + "}";
}

std::string encode_error(const json& id, const RpcError& error) {
    const json body = {{"code", error.code},
                       {"message", error.error.message},
                       {"data", {{"kind", std::string(to_string(error.error.kind))}}}};
    return R"({"jsonrpc":"2.0","id":)" + dump(id) + R"(,"error":)" + dump(body) + "}";
}

}  // namespace camrig
