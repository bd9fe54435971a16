#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>

#include "control/rpc/method.h"
#include "core/base/result.h"

/// JSON-RPC 2.0 messages (specification of 2013-01-04), without transport and without methods.
namespace camrig::control {

/// Longest request line or body.
inline constexpr std::size_t max_request_bytes = std::size_t{1} << 20;
inline constexpr std::size_t max_batch = 64;

namespace rpc_code {
inline constexpr int parse_error = -32700;
inline constexpr int invalid_request = -32600;
inline constexpr int method_not_found = -32601;
inline constexpr int invalid_params = -32602;
inline constexpr int application = -32000;
}  // namespace rpc_code

/// One well-formed request. No id: a notification, which gets no answer.
struct RpcRequest {
    std::optional<nlohmann::json> id;
    std::string method;
    nlohmann::json params = nlohmann::json::object();
};

/// What is wrong with a message or a call.
struct RpcError {
    int code = rpc_code::application;
    Error error;
    nlohmann::json id = nullptr;
    bool is_of_notification = false;  ///< which gets no answer, also where its params are wrong (section 4.1)
};

struct RpcMessage {
    bool is_batch = false;
    std::vector<std::variant<RpcRequest, RpcError>> items;
};

/// Reads one message. Never fails: what cannot be read is an RpcError item.
RpcMessage parse_rpc(std::string_view text);

/// The text of an answer, without a line end. Large text stays in a piece of its own, so that it is never copied
/// together with the rest. Holds what is claimed of the budgets of answers until it is gone.
struct RpcAnswer {
    std::vector<std::string> pieces;  ///< one after the other; none: there is nothing to answer
    std::string after_line = {};      ///< bytes behind its end (RpcResult::is_bytes)
    std::vector<ByteBudget::Claim> claims;

    void append(std::string text);
    void append(RpcAnswer answer);
    std::size_t size() const;
    std::string joined() const;
};

/// One line without its end. Text that is not UTF-8 is replaced, never an exception.
RpcAnswer rpc_result(const nlohmann::json& id, RpcResult result);
std::string rpc_error(const RpcError& error);
/// The code under which an error of a handler is told: invalid_params for invalid_argument, else application.
int rpc_code_of(ErrorKind kind);

}  // namespace camrig::control
