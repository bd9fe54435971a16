#include <algorithm>
#include <string>

#include "control/rpc/generated_files.h"
#include "control/rpc/json_rpc.h"
#include "control/rpc/method_shapes.h"
#include "control/rpc/methods.h"
#include "core/base/descriptors.h"
#include "core/fault/fault_kind.h"

// docs/control-protocol.md is made here, from the method table; a unit test compares the two.
namespace camrig::control {
namespace {

using nlohmann::json;

/// Answers every command and every request for a picture: there is no rig behind documentation.
class NoRig final : public engine::CommandPort, public stream::FrameFetcher {
public:
    void post(engine::Command command) override {
        std::visit([](auto& request) { request.done(std::unexpected(nothing())); }, command);
    }
    void fetch(stream::FetchRequest, std::function<void(Result<stream::MediaUnit>)> done) override {
        done(std::unexpected(nothing()));
    }

private:
    static Error nothing() { return {ErrorKind::unavailable, "there is no rig here"}; }
};

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '|') out += '\\';
        out += c;
    }
    return out;
}

std::string type_of(const Field& field) {
    return escaped(field.type) + (field.unit.empty() ? "" : ", " + field.unit);
}

}  // namespace

std::string param_row(const Field& field) {
    const std::string fallback = field.required ? "required" : escaped(field.fallback);
    return "| `" + field.name + "` | " + type_of(field) + " | " + fallback + " | " + escaped(field.doc_text()) + " |\n";
}

void params_table(std::string& out, const std::vector<Field>& fields) {
    out += "| parameter | type | default | |\n|---|---|---|---|\n";
    for (const Field& field : fields) out += param_row(field);
    out += "\n";
}

namespace {

void result_table(std::string& out, const std::vector<Field>& fields) {
    out += "| result | type | |\n|---|---|---|\n";
    for (const Field& field : fields)
        out += "| `" + field.name + "` | " + type_of(field) + " | " + escaped(field.doc_text()) + " |\n";
    out += "\n";
}

void method_section(std::string& out, const Method& method) {
    out += "### `" + method.name + "`\n\n" + method.summary +
           (method.only_looks ? " *Open to all who may look.*\n\n" : "\n\n");
    if (method.params.empty()) {
        out += "No parameters.\n\n";
    } else {
        params_table(out, method.params);
    }
    result_table(out, method.result);
    if (!method.errors.empty()) {
        out += "Errors: ";
        for (std::size_t i = 0; i < method.errors.size(); ++i)
            out += std::string(i ? ", " : "") + "`" + std::string(to_string(method.errors[i])) + "`";
        out += ".\n\n";
    }
    const std::string params = method.example == "{}" ? "" : ",\"params\":" + method.example;
    out += "```json\n{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"" + method.name + "\"" + params + "}\n```\n\n";
}

std::string mib(std::size_t bytes) {
    return std::to_string(bytes >> 20) + " MiB";
}
std::string seconds(ControlLimits::Duration time) {
    return std::to_string(time.count() / 1000) + " s";
}

std::string limits_section() {
    const ControlLimits limits;
    const auto number = [](std::size_t value) { return std::to_string(value); };
    return "## Limits\n\n| what | bound | beyond it |\n|---|---|---|\n"
           "| one message (line, or body of `POST /rpc`) | " +
           mib(limits.line_bytes) + " | an error, then the connection is closed |\n| requests in a batch | " +
           number(max_batch) + " | an error |\n| one answer, or all answers of a batch | " + mib(limits.reply_bytes) +
           " | `resource_exhausted` for what does not fit; ask one at a time |\n| connections on the Unix socket, and "
           "as "
           "many over TCP | " +
           number(limits.connections) +
           " | the one that has been idle longest is closed; if none is, the new one gets an error "
           "|\n| connections over TCP that have not shown the token | " +
           number(limits.unauthorized_connections) +
           " | the oldest is closed |\n| connections over TCP while fewer file descriptors are free than | " +
           std::to_string(reserved_descriptors) +
           " | the new one gets an error; the Unix socket takes all |\n| messages of one connection in work | " +
           number(limits.in_flight) +
           " | the connection is not read until one is answered |\n| answers of one connection being made or not sent "
           "yet | " +
           mib(limits.unsent_reply_bytes) + " | the connection is not read until they are |\n| the same | " +
           mib(limits.queued_reply_bytes) + " (" + mib(limits.total_reply_bytes) +
           " of all connections and `POST /rpc`, with the pictures being made) | `resource_exhausted` |\n| a client "
           "that takes no byte of a reply | " +
           seconds(limits.stalled_after) + " | the connection is closed |\n| first line where a token is asked for | " +
           number(limits.unauthorized_line_bytes) + " bytes, " + seconds(limits.authorize_time) +
           " | the connection is closed |\n| one picture of `frame.get`, before base64 | " + mib(max_frame_bytes) +
           " | `resource_exhausted` |\n| cameras | " + number(engine::max_cameras) +
           " | `resource_exhausted` |\n| pixels of all cameras together | " +
           std::to_string(engine::max_total_pixels >> 20) +
           " Mpixel (of 2^20) | `resource_exhausted` |\n| commands waiting for the world | " +
           number(engine::max_queued_commands) + " | `resource_exhausted` |\n| scenes waiting to be loaded | " +
           number(max_scenes_waiting) + " | `resource_exhausted` |\n| photos waiting to be calibrated | " +
           number(max_searches_waiting) + " | `resource_exhausted` |\n\n";
}

json to_json(const Method& method) {
    json errors = json::array();
    for (const ErrorKind kind : method.errors) errors.push_back(std::string(to_string(kind)));
    return {{"name", method.name},
            {"summary", method.summary},
            {"params", to_json(method.params)},
            {"result", to_json(method.result)},
            {"errors", std::move(errors)}};
}

}  // namespace

json protocol_description() {
    json methods = json::array(), objects = json::object(), kinds = json::object();
    for (const Method& method : documented_methods()) methods.push_back(to_json(method));
    objects["camera"] = to_json(camera_descriptions());
    for (const auto& [name, fields] : objects_of_methods()) objects[name] = to_json(fields);
    auto all = kinds_of_methods();
    all.push_back({"fault", "kind", descriptions_of(fault::fault_kinds())});
    for (const KindsDescription& described : all)
        for (const KindDescription& kind : described.kinds)
            kinds[described.name].push_back({{"name", kind.name}, {"doc", kind.doc}, {"fields", to_json(kind.fields)}});
    return {{"methods", std::move(methods)}, {"objects", std::move(objects)}, {"kinds", std::move(kinds)}};
}

const std::vector<Method>& documented_methods() {
    static NoRig no_rig;
    static RpcContext context{no_rig, no_rig};
    static const std::vector<Method> methods = make_methods(context, [] { return nlohmann::json::object(); });
    return methods;
}

const Method& documented_method(std::string_view name) {
    const auto found = std::ranges::find(documented_methods(), name, &Method::name);
    CHECK(found != documented_methods().end());
    return *found;
}

std::string control_protocol_markdown(const std::vector<Method>& methods) {
    std::string out(protocol_introduction());
    out += limits_section();
    out += "## Objects\n\n";
    for (const SharedObject& object : shared_objects()) {
        out += "### " + object.name + "\n\n" + object.summary + "\n\n";
        params_table(out, object.fields);
    }
    out += "## Methods\n\n";
    for (const Method& method : methods) method_section(out, method);
    while (out.ends_with("\n\n")) out.pop_back();
    return out;
}

}  // namespace camrig::control
