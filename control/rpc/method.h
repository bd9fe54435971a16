#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/byte_budget.h"
#include "core/base/field.h"
#include "core/base/result.h"

namespace camrig::control {

/// What a method gives back. `data` is for large base64 text, which inside of `fields` would be copied and scanned
/// twice; it becomes the last member, "data".
struct RpcResult {
    RpcResult(nlohmann::json all_fields, std::string big_data = {})  // NOLINT: a JSON object is a result
        : fields(std::move(all_fields)), data(std::move(big_data)) {}

    nlohmann::json fields;
    std::string data;
    /// `data` is no JSON text: it follows the answer's line, and `fields` says how many bytes they are. Only where
    /// RpcReply::takes_bytes().
    bool is_bytes = false;
    /// What was claimed for `data` of the reply's budget. Nothing: the whole answer is claimed when it has become text.
    std::optional<ByteBudget::Claim> claim = {};
};

/// Answers one call, exactly once, from any thread.
class RpcReply {
public:
    template <typename Function>
        requires(!std::same_as<std::remove_cvref_t<Function>, RpcReply> && std::invocable<Function&, Result<RpcResult>>)
    RpcReply(Function function, std::shared_ptr<ByteBudget> budget = {},  // NOLINT: a function is a reply
             bool takes_bytes = false)
        : function_(std::move(function)), budget_(std::move(budget)), takes_bytes_(takes_bytes) {}

    void operator()(Result<RpcResult> result) const { function_(std::move(result)); }
    /// What the bytes of the answer count against, together with all other answers of its batch. Null where nobody
    /// counts.
    const std::shared_ptr<ByteBudget>& budget() const { return budget_; }
    /// Whether bytes may follow the answer: it is no part of a batch, and goes where lines are read.
    bool takes_bytes() const { return takes_bytes_; }

    /// What was asked beside what the method reads itself (Handler::takes_time).
    struct Asked {
        std::optional<std::int64_t> at_ns = {};        ///< world time at which it is done
        std::shared_ptr<const std::string> text = {};  ///< for the command log; null: nobody keeps one
    };
    const Asked& asked() const { return asked_; }
    void set_asked(Asked asked) { asked_ = std::move(asked); }

private:
    std::function<void(Result<RpcResult>)> function_;
    std::shared_ptr<ByteBudget> budget_;
    bool takes_bytes_ = false;
    Asked asked_;
};

inline Error out_of_memory() {
    return {ErrorKind::resource_exhausted, "the rig has no memory for this answer; ask for less at once"};
}
/// That error in the place of what there is no memory for.
template <typename Make>
Result<RpcResult> unless_out_of_memory(Make&& make) {
    try {
        return std::forward<Make>(make)();
    } catch (const std::bad_alloc&) {
        return std::unexpected(out_of_memory());
    }
}

/// What the sender of a message may do (docs/control-protocol.md, "Who may command").
enum class Authority : std::uint8_t {
    look,     ///< methods that only look
    command,  ///< all methods
    own,      ///< all methods, by the rig's own user on its Unix socket: may read whatever the rig may
};

/// Answers the calls of a method.
class Handler {
public:
    /// The function gets an object whose keys are all in Method::params and which has the required ones. It must not
    /// block. `takes_time`: what it does may be asked for a world time (engine::Timed), RpcReply::Asked::at_ns.
    template <typename Function>
        requires(!std::same_as<std::remove_cvref_t<Function>, Handler> &&
                 std::invocable<Function&, const nlohmann::json&, RpcReply>)
    Handler(Function function, bool takes_time = false)  // NOLINT: a function is a handler
        : function_(std::move(function)), takes_time_(takes_time) {}

    void operator()(const nlohmann::json& params, RpcReply done) const { function_(params, std::move(done)); }
    bool takes_time() const { return takes_time_; }

private:
    std::function<void(const nlohmann::json& params, RpcReply done)> function_;
    bool takes_time_;
};

/// A method, described in one place: the dispatcher's check of parameter names, docs/control-protocol.md, `camrig
/// methods` and server.info all come from here. A method without an example that runs fails the unit tests.
struct Method {
    std::string name;
    std::string summary;
    std::vector<Field> params;
    std::vector<Field> result;
    std::vector<ErrorKind> errors;
    Handler handler;
    std::string example = "{}";  ///< parameters as JSON text
    bool only_looks = false;     ///< changes nothing and reads no files: also for those who may not command
    bool reads_files = false;    ///< its errors may tell of files: in full to the rig's owner only
};

}  // namespace camrig::control
