#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/result.h"

namespace camrig {

/// One parameter or one field of a result, as the documentation shows it.
struct Field {
    std::string name;
    std::string type;  ///< "string", "number", "[w, h]", "object", ...
    std::string doc;
    bool required = false;
};

/// Answers one call, exactly once, from any thread.
using RpcReply = std::function<void(Result<nlohmann::json>)>;

/// A method, described in one place: the dispatcher's check of parameter names, docs/control-protocol.md and server.info
/// all come from here.
struct Method {
    std::string name;
    std::string summary;
    std::vector<Field> params;
    std::vector<Field> result;
    std::vector<ErrorKind> errors;
    /// Gets an object whose keys are all in `params` and which has the required ones. Must not block.
    std::function<void(const nlohmann::json& params, RpcReply done)> handler;
};

}  // namespace camrig
