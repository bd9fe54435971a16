#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/result.h"

namespace camrig {

/// One parameter or one field of a result, as the documentation shows it.
struct Field {
    std::string name;
    std::string type;  ///< "string", "number", "[width, height]", "object", ...
    std::string doc;
    bool required = false;
    std::string unit = {};      ///< "m", "deg", "ns", ...; empty: none
    std::string fallback = {};  ///< what holds when the parameter is not given; empty: nothing, or as it is
};

/// What a method gives back. `data` is for large base64 text, which inside of `fields` would be copied and scanned
/// twice; it becomes the last member, "data".
struct RpcResult {
    RpcResult(nlohmann::json all_fields, std::string big_data = {})  // NOLINT: a JSON object is a result
        : fields(std::move(all_fields)), data(std::move(big_data)) {}

    nlohmann::json fields;
    std::string data;
};

/// Answers one call, exactly once, from any thread.
using RpcReply = std::function<void(Result<RpcResult>)>;

/// What the sender of a message may do (docs/control-protocol.md, "Who may command").
enum class Authority : std::uint8_t {
    look,     ///< methods that only look
    command,  ///< all methods
    own,      ///< all methods, by the rig's own user on its Unix socket: may read whatever the rig may
};

/// A method, described in one place: the dispatcher's check of parameter names, docs/control-protocol.md, `camrig
/// methods` and server.info all come from here. A method without an example that runs fails the unit tests.
struct Method {
    std::string name;
    std::string summary;
    std::vector<Field> params;
    std::vector<Field> result;
    std::vector<ErrorKind> errors;
    /// Gets an object whose keys are all in `params` and which has the required ones. Must not block.
    std::function<void(const nlohmann::json& params, RpcReply done)> handler;
    std::string example = "{}";  ///< parameters as JSON text
    bool only_looks = false;     ///< changes nothing and reads no files: also for those who may not command
    bool reads_files = false;    ///< its errors may tell of files: in full to the rig's owner only
};

}  // namespace camrig
