#include "control/rpc/json_rpc.h"
#include "control/rpc/methods.h"

namespace camrig {

using nlohmann::json;

std::vector<Method> rig_methods(RpcContext& context, std::function<json()> call_counts) {
    return {
        {"stats.get",
         "Counts and stage times of the whole rig.",
         {},
         {{"world_ns", "integer", "world time, ns"},
          {"monotonic_ns", "integer", "CLOCK_MONOTONIC, ns"},
          {"instants", "integer", "instants at which something was due"},
          {"dropped_instants", "integer", "those skipped as a whole under overload"},
          {"cameras", "array", "per camera: due = rendered + dropped, idle, outputs with their readers"},
          {"stages", "array", "per stage: count, mean_ms, p50_ms, p99_ms, max_ms"}},
         {},
         [&context](const json&, RpcReply done) {
             post(context, GetStats{}, std::move(done), [](const RigReport& report) { return to_json(report); });
         }},
        {"server.info",
         "What this rig is and where it listens.",
         {},
         {{"version", "string", "of camrig"},
          {"pid", "integer", "process id"},
          {"renderer", "string", "device and driver"},
          {"control", "string", "path of the control socket"},
          {"http", "integer", "port"},
          {"rtsp", "integer", "port; 0: off"},
          {"methods", "array of strings", "all methods"},
          {"calls", "object", "how often each was called"}},
         {},
         [&context, call_counts = std::move(call_counts)](const json&, RpcReply done) {
             json info = context.info ? context.info() : json::object();
             info["calls"] = call_counts();
             done(std::move(info));
         }},
        {"server.shutdown",
         "Ends the rig, after this answer.",
         {},
         {{"stopping", "boolean", "true"}},
         {},
         [&context](const json&, RpcReply done) {
             done(json{{"stopping", true}});
             if (context.shutdown) context.shutdown();
         }},
    };
}

}  // namespace camrig
