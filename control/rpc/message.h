#pragma once

#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "control/rpc/limits.h"
#include "core/base/result.h"

/// JSON-RPC 2.0 as text: what comes in and what goes out (https://www.jsonrpc.org/specification).
namespace camrig {

namespace rpc_code {
inline constexpr int parse_error = -32700;
inline constexpr int invalid_request = -32600;
inline constexpr int method_not_found = -32601;
inline constexpr int invalid_params = -32602;
inline constexpr int failed = -32000;  ///< everything that is not the caller's parameters; data.kind says what
}  // namespace rpc_code

struct RpcError {
    int code = rpc_code::failed;
    Error error;
};

/// The code that goes with an error of ours: invalid_argument is invalid_params, all others are `failed`.
RpcError rpc_error(Error error);

struct RpcRequest {
    std::string method;
    nlohmann::json params = nlohmann::json::object();  ///< always an object: parameters go by name
    nlohmann::json id;                                 ///< string, number or null
    bool is_notification = false;                      ///< no id: executed, never answered
};

/// A message that is no request, with the id to answer to (null when it has no usable one).
struct BadRequest {
    nlohmann::json id;
    RpcError why;
};

struct RpcMessage {
    bool is_batch = false;
    std::vector<std::expected<RpcRequest, BadRequest>> items;  ///< one, or those of the batch
};

/// Never fails as a whole: text that cannot be read is one BadRequest. Unknown members beside jsonrpc, method, params
/// and id are refused: they are typing errors that would change what is asked.
RpcMessage decode_message(std::string_view text, const ControlLimits& limits);

/// What a method gives back. `data` is for large base64 text, which would be copied and scanned twice inside of `fields`;
/// it becomes the last member, "data".
struct RpcResult {
    nlohmann::json fields = nlohmann::json::object();
    std::string data;
};

/// One line without its end. Text that is not UTF-8 is replaced, never an exception.
std::string encode_result(const nlohmann::json& id, const RpcResult& result);
std::string encode_error(const nlohmann::json& id, const RpcError& error);

}  // namespace camrig
