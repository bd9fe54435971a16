#pragma once

#include <functional>
#include <string>
#include <vector>

#include "control/rpc/method.h"
#include "control/rpc/rpc_server.h"
#include "core/base/field_of.h"
#include "core/world/scene_check.h"

/// The families of methods. A new method is one entry in one of these files.
namespace camrig::control {

std::vector<Method> camera_methods(RpcContext& context);
std::vector<Method> ptz_methods(RpcContext& context);
std::vector<Method> fault_methods(RpcContext& context);
std::vector<Method> world_methods(RpcContext& context);
std::vector<Method> frame_methods(RpcContext& context);
std::vector<Method> actor_methods(RpcContext& context);
std::vector<Method> object_methods(RpcContext& context);
std::vector<Method> event_methods(RpcContext& context);
std::vector<Method> truth_methods(RpcContext& context);
std::vector<Method> replica_methods(RpcContext& context);
std::vector<Method> plate_methods(RpcContext& context);
std::vector<Method> rig_methods(RpcContext& context, std::function<nlohmann::json()> call_counts);

nlohmann::json to_json(const engine::CameraReply& report);
nlohmann::json to_json(const stream::RigReport& report);
/// What scene.check answers, and `camrig check --json`.
nlohmann::json to_json(const world::SceneCheck& check);
nlohmann::json applied_json(const engine::Applied& done);
std::string hex_text(std::uint64_t bits);

/// Posts a command and turns its reply into JSON, on the thread for replies: the engine's has no time for text.
template <typename C, typename ToJson>
void post(RpcContext& context, C command, RpcReply done, ToJson to_json_of_reply) {
    const RpcReply::Asked asked = done.asked();
    context.commands.post(
        engine::Request<C>{std::move(command),
                           [replies = context.replies, done = std::move(done), to_json_of_reply](auto reply) {
                               if (!reply) return done(std::unexpected(reply.error()));
                               std::function<void()> job = [done, to_json_of_reply, value = std::move(*reply)] {
                                   done(unless_out_of_memory([&] { return RpcResult(to_json_of_reply(value)); }));
                               };
                               if (!replies->post(std::move(job))) job();
                           },
                           asked.at_ns, asked.text});
}

/// The handler of a method that is one command: `read` makes it from the parameters (a Result), `to_json_of_reply` text
/// of its reply.
template <typename Read, typename ToJson>
Handler handler_of(RpcContext& context, Read read, ToJson to_json_of_reply) {
    using Command = typename std::invoke_result_t<Read&, JsonReader&>::value_type;
    const auto handle = [&context, read, to_json_of_reply](const nlohmann::json& params, RpcReply done) {
        JsonReader reader(params, "");
        auto command = read(reader);
        if (!command) return done(std::unexpected(command.error()));
        post(context, std::move(*command), std::move(done), to_json_of_reply);
    };
    return {handle, engine::Timed<Command>};
}

/// The same where the parameters are the fields of the command, as this table says.
template <typename C, typename ToJson>
Handler handler_of(RpcContext& context, const std::vector<FieldOf<C>>& table, ToJson to_json_of_reply) {
    return handler_of(context, [table](JsonReader& reader) { return read_all(table, reader); }, to_json_of_reply);
}

/// The same for a command without parameters.
template <typename C, typename ToJson>
Handler handler_of(RpcContext& context, ToJson to_json_of_reply) {
    return handler_of(context, std::vector<FieldOf<C>>{}, to_json_of_reply);
}

/// What was made or changed, and when that shows: the fields of its report and applied_ns.
template <typename Report>
nlohmann::json change_json(const engine::AppliedReport<Report>& change) {
    nlohmann::json value = json_of(change.report);
    value["applied_ns"] = change.applied_ns;
    return value;
}
template <typename Report>
std::vector<Field> change_fields(const char* applied_doc) {
    auto fields = descriptions_of<Report>();
    fields.push_back({"applied_ns", "integer", applied_doc, false, "ns"});
    return fields;
}

/// A list of what has a table.
template <typename T>
nlohmann::json list_json(const std::vector<T>& values) {
    nlohmann::json list = nlohmann::json::array();
    for (const T& value : values) list.push_back(json_of(value));
    return list;
}

}  // namespace camrig::control
