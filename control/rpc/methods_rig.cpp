#include "control/rpc/json_rpc.h"
#include "control/rpc/methods.h"
#include "core/base/json_reader.h"
#include "core/base/token.h"

namespace camrig::control {
namespace {

using nlohmann::json;

json limits_json(const ControlLimits& limits) {
    return {{"line_bytes", limits.line_bytes},
            {"batch", max_batch},
            {"connections", limits.connections},
            {"unauthorized_connections", limits.unauthorized_connections},
            {"in_flight", limits.in_flight},
            {"reply_bytes", limits.reply_bytes},
            {"queued_reply_bytes", limits.queued_reply_bytes},
            {"frame_bytes", max_frame_bytes},
            {"queued_commands", engine::max_queued_commands},
            {"stalled_after_ms", limits.stalled_after.count()}};
}

void authorize(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    std::string token;
    reader.required("token", token);
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    if (!context.token.empty() && !equal_tokens(token, context.token))
        return done(error(ErrorKind::unauthorized,
                          "this is not the rig's token (the one in its --token-file, or in its key file)"));
    done(json{{"authorized", true}});
}

std::vector<Field> info_fields() {
    return {{"version", "string", "of camrig"},
            {"pid", "integer", "process id"},
            {"uptime_s", "number", "since the start", false, "s"},
            {"renderer", "string", "device and driver that draw"},
            {"control", "string", "path of the control socket"},
            {"host", "string", "address that the ports belong to"},
            {"http", "integer", "port"},
            {"rtsp", "integer", "port; 0: off"},
            {"rtsp_scheme", "string", "of its addresses: rtsp, or rtsps with --rtsp-cert"},
            {"tcp", "integer", "port of control over TCP; 0: off"},
            {"key_file", "string", "file with the key that commands over HTTP and TCP need; absent: none is needed"},
            {"connections", "object",
             "per server (control, http, rtsp) its connections since the start: open now, taken in total, refused (no "
             "place, or descriptors are short), displaced (closed, while idle, for a new one), and wrong_tokens shown"},
            {"methods", "array of strings", "all methods"},
            {"calls", "object", "how often each was called"},
            {"limits", "object", "the bounds, see limits"}};
}

}  // namespace

std::vector<Method> rig_methods(RpcContext& context, std::function<json()> call_counts) {
    using enum ErrorKind;
    return {
        {.name = "stats.get",
         .summary =
             "Counts and stage times of the whole rig. Per camera due = rendered + dropped; per output due = received "
             "+ fault + not_drawn and received = encoded + dropped + failed + kept_back; per reader offered = "
             "delivered + dropped + what is on its way. A frame "
             "counts "
             "when it is drawn or dropped: what waits for its turn is still to come.",
         .params = {},
         .result =
             {{"world_ns", "integer", "world time", false, "ns"},
              {"monotonic_ns", "integer", "CLOCK_MONOTONIC", false, "ns"},
              {"instants", "integer", "instants at which something was due"},
              {"dropped_instants", "integer", "those of which pictures were dropped because there was not time enough"},
              {"cameras", "array of objects",
               "name, due, rendered, dropped, idle and outputs with their readers. dropped_for says why: overload "
               "(too little time for all cameras), own_cost (this camera's pictures cost more than its share), "
               "request (pictures and truth on request took the time), failure (the log says which), fault "
               "(fault.set), held (world.limit). "
               "Of an output, fault and not_drawn are frames that its readers would have taken, and kept_back those "
               "that none "
               "of them was given (fault stall or disconnect); of a reader, fault are those of its dropped that a "
               "fault "
               "kept back, and damaged those whose bytes one changed"},
              {"stages", "array of objects",
               "name, count, mean_ms, p50_ms, p99_ms, p999_ms and max_ms since the start. wakeup: how late an "
               "instant began; world: per instant; draw and publish: per turn, of one "
               "picture or several; convert and encode: per picture; truth: per answer"},
              {"renderer", "object",
               "what the renderer keeps and saves: static layers, pictures drawn in parts, skinned meshes made "
               "and left out, draw calls"}},
         .errors = {},
         .handler =
             handler_of<engine::GetStats>(context, [](const stream::RigReport& report) { return to_json(report); }),
         .only_looks = true},
        {.name = "server.info",
         .summary = "What this rig is and where it listens.",
         .params = {},
         .result = info_fields(),
         .errors = {},
         .handler =
             [&context, call_counts = std::move(call_counts)](const json&, RpcReply done) {
                 json info = context.info ? context.info() : json::object();
                 info["calls"] = call_counts();
                 info["limits"] = limits_json(context.limits);
                 done(std::move(info));
             },
         .only_looks = true},
        {.name = "server.shutdown",
         .summary = "Ends the rig, after this answer.",
         .params = {},
         .result = {{"stopping", "boolean", "true"}},
         .errors = {},
         .handler =
             [&context](const json&, RpcReply done) {
                 done(json{{"stopping", true}});
                 if (context.shutdown) context.shutdown();
             }},
        {.name = "server.describe",
         .summary = "What can be asked of this rig, and the parameters of its objects with type, unit, range, choices "
                    "and default: for programs that make their user interface from it.",
         .params = {},
         .result =
             {{"methods", "array of objects", "each name, summary, params, result and errors"},
              {"objects", "object",
               "`camera`, `actor`, `attachment`, `event`: their parameters, each name, type, doc, and where there are "
               "any: required, unit, default, "
               "minimum, exclusive_minimum, maximum, exclusive_maximum, choices, null (what null means), label, "
               "by (`client` or `rig`: who alone says it), fields (of an object) and whole (an object that is given "
               "takes the place of all of the one before)"},
              {"kinds", "object", "`behaviour`, `trigger`, `action`, `fault`: each kind's name, doc and fields"}},
         .errors = {},
         .handler = [](const json&, RpcReply done) { done(protocol_description()); },
         .only_looks = true},
        {.name = "auth",
         .summary =
             "Shows the token or the key. Where one is asked for (TCP) this is the first line of a connection, or the "
             "connection is closed; elsewhere it is not needed.",
         .params = {{"token", "string", "the line in the rig's --token-file, or in its key file", true}},
         .result = {{"authorized", "boolean", "true"}},
         .errors = {invalid_argument, unauthorized},
         .handler = [&context](const json& params, RpcReply done) { authorize(context, params, std::move(done)); },
         .example = R"({"token": "0123456789abcdef"})",
         .only_looks = true},
    };
}

}  // namespace camrig::control
