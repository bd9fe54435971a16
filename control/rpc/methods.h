#pragma once

#include <functional>
#include <string>
#include <vector>

#include "control/rpc/method.h"
#include "control/rpc/rpc_server.h"
#include "control/rpc/work_thread.h"

/// The families of methods. A new method is one entry in one of these files.
namespace camrig {

std::vector<Method> camera_methods(RpcContext& context);
std::vector<Method> world_methods(RpcContext& context);
std::vector<Method> frame_methods(RpcContext& context);
std::vector<Method> actor_methods(RpcContext& context);
std::vector<Method> event_methods(RpcContext& context);
std::vector<Method> truth_methods(RpcContext& context);
std::vector<Method> rig_methods(RpcContext& context, std::function<nlohmann::json()> call_counts);

nlohmann::json to_json(const CameraReply& report);
nlohmann::json to_json(const WorldState& state);
nlohmann::json to_json(const RigReport& report);
std::string hex_text(std::uint64_t bits);

/// Posts a command and turns its reply into JSON, on the thread for replies: the engine's has no time for text.
template <typename C, typename ToJson>
void post(RpcContext& context, C command, RpcReply done, ToJson to_json_of_reply) {
    context.commands.post(Request<C>{
        std::move(command), [replies = context.replies, done = std::move(done), to_json_of_reply](auto reply) {
            if (!reply) return done(std::unexpected(reply.error()));
            std::function<void()> job = [done, to_json_of_reply, value = std::move(*reply)] {
                done(unless_out_of_memory([&] { return RpcResult(to_json_of_reply(value)); }));
            };
            if (!replies->post(job)) job();
        }});
}

}  // namespace camrig
