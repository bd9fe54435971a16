#include <string>

#include "control/rpc/methods.h"
#include "core/world/camera_fields.h"
#include "core/world/camera_json.h"

namespace camrig::control {

using nlohmann::json;

/// 64 bits are more than a JSON number holds for certain.
std::string hex_text(std::uint64_t bits) {
    std::string text(16, '0');
    for (std::size_t i = 16; i-- > 0; bits >>= 4) text[i] = "0123456789abcdef"[bits & 0xf];
    return text;
}

json to_json(const engine::CameraReply& report) {
    json value = camera_to_json(report.camera.spec_at(report.now.world_ns));
    value["world_pose"] = world::pose_to_json(report.now.believed_pose.value_or(report.now.pose));
    value["shown_intrinsics"] = json_of(report.now.intrinsics);
    value["id"] = static_cast<std::uint32_t>(report.id);
    value["sequence"] = report.sequence;
    value["readers"] = report.readers;
    value["applied_ns"] = report.applied_ns;
    value["arrives_ns"] = report.camera.arrives_ns();
    return value;
}

json applied_json(const engine::Applied& done) {
    return {{"applied_ns", done.applied_ns}};
}

json to_json(const stream::RigReport& report) {
    json cameras = json::array();
    for (const auto& camera : report.cameras) {
        json outputs = json::array();
        for (const auto& output : camera.outputs) {
            json readers = json::array();
            for (const auto& reader : output.readers) {
                readers.push_back({{"kind", reader.kind},
                                   {"peer", reader.peer},
                                   {"offered", reader.offered},
                                   {"delivered", reader.delivered},
                                   {"dropped", reader.dropped},
                                   {"fault", reader.fault},
                                   {"damaged", reader.damaged},
                                   {"bytes", reader.bytes},
                                   {"latency_ms", reader.latency_ms}});
            }
            outputs.push_back({{"format", output.format},
                               {"due", output.due},
                               {"fault", output.fault},
                               {"not_drawn", output.not_drawn},
                               {"received", output.received},
                               {"encoded", output.encoded},
                               {"dropped", output.dropped},
                               {"failed", output.failed},
                               {"kept_back", output.kept_back},
                               {"readers", std::move(readers)}});
        }
        json dropped_for = json::object();
        for (std::size_t i = 0; i < stream::drop_reason_names.size(); ++i)
            dropped_for[std::string(stream::drop_reason_names[i])] = camera.dropped_for[i];
        cameras.push_back({{"name", camera.name},
                           {"due", camera.due},
                           {"rendered", camera.rendered},
                           {"dropped", camera.dropped},
                           {"dropped_for", std::move(dropped_for)},
                           {"idle", camera.idle},
                           {"outputs", std::move(outputs)}});
    }
    json stages = json::array();
    for (const auto& stage : report.stages) {
        stages.push_back({{"name", stage.name},
                          {"count", stage.summary.count},
                          {"mean_ms", stage.summary.mean_ms},
                          {"p50_ms", stage.summary.p50_ms},
                          {"p99_ms", stage.summary.p99_ms},
                          {"p999_ms", stage.summary.p999_ms},
                          {"max_ms", stage.summary.max_ms}});
    }
    json renderer = json::object();
    for (const auto& counter : report.renderer) renderer[std::string(counter.name)] = counter.value;
    return {{"world_ns", report.world_ns},    {"monotonic_ns", report.monotonic_ns},
            {"instants", report.instants},    {"dropped_instants", report.dropped_instants},
            {"cameras", std::move(cameras)},  {"stages", std::move(stages)},
            {"renderer", std::move(renderer)}};
}

}  // namespace camrig::control
