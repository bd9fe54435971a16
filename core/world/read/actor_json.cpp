#include "core/world/read/actor_json.h"

#include <cmath>

#include "core/world/read/behaviour_json.h"
#include "core/world/read/json_parts.h"
#include "core/world/turn.h"

namespace camrig {

using nlohmann::json;

namespace {

constexpr double max_scale = 1e6;

template <typename Behaviour>
void read_behaviour_key(JsonReader& reader, Behaviour& out) {
    const json* value = reader.find("behaviour");
    if (!value) return;
    auto behaviour = read_behaviour(*value, reader.path_of("behaviour"));
    if (behaviour)
        out = std::move(*behaviour);
    else
        reader.fail(behaviour.error());
}

}  // namespace

void read_attachment(JsonReader& reader, std::string_view key, std::optional<Attachment>& out) {
    const json* value = reader.find(key);
    if (!value) return;
    JsonReader nested(*value, reader.path_of(key));
    Attachment attachment;
    required_name(nested, "actor", attachment.actor);
    nested.optional("node", attachment.node);
    read_vector(nested, "position", attachment.position);
    read_orientation(nested, attachment.orientation);
    if (auto done = nested.finish(); !done) return reader.fail(done.error());
    out = std::move(attachment);
}

Result<ActorSpec> read_actor(JsonReader& reader) {
    ActorSpec actor;
    required_name(reader, "name", actor.name);
    reader.required("model", actor.model);
    optional_name(reader, "class", actor.object_class);
    bool placed = read_vector(reader, "position", actor.position);
    placed = read_orientation(reader, actor.orientation) || placed;
    optional_in_range(reader, "scale", actor.scale, 1e-6, max_scale);
    if (reader.has("radius_m")) optional_in_range(reader, "radius_m", actor.radius_m.emplace(), 0.0, 100.0);
    read_attachment(reader, "attach", actor.attach);
    read_behaviour_key(reader, actor.behaviour);
    if (placed && places_actor(actor.behaviour))
        reader.fail("position", "its route places this actor; leave position and orientation out");
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return actor;
}

Result<ActorPatch> read_actor_patch(JsonReader& reader) {
    ActorPatch patch;
    required_name(reader, "name", patch.name);
    glm::dvec3 position(0.0);
    glm::dquat orientation(1.0, 0.0, 0.0, 0.0);
    if (read_vector(reader, "position", position)) patch.position = position;
    if (read_orientation(reader, orientation)) patch.orientation = orientation;
    read_behaviour_key(reader, patch.behaviour);
    read_attachment(reader, "attach", patch.attach);
    reader.optional("detach", patch.detach);
    if (patch.attach && patch.detach) reader.fail("detach", "give either attach or detach");
    reader.optional("play", patch.play);
    optional_in_range(reader, "play_speed", patch.play_speed, 0.0, 100.0);
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return patch;
}

Result<SteerSpec> read_steer(const json& value, std::string path) {
    JsonReader reader(value, std::move(path));
    SteerSpec steer;
    required_name(reader, "name", steer.name);
    glm::dvec3 vector(0.0);
    if (read_vector(reader, "velocity", vector)) {
        steer.velocity = vector;
        if (glm::length(vector) > max_speed_m_s) reader.fail("velocity", "expected at most 1000 m/s");
    }
    if (read_vector(reader, "position", vector)) steer.position = vector;
    if (steer.velocity && steer.position) reader.fail("position", "give either velocity or position");
    double over_s = 0.0;
    optional_in_range(reader, "seconds", over_s, 0.0, 3600.0);
    if (reader.has("seconds") && !steer.position) reader.fail("seconds", "belongs to a position");
    if (reader.ok()) steer.over_ns = std::llround(over_s * 1e9);
    std::optional<double> yaw_deg;
    reader.optional("yaw_deg", yaw_deg);
    if (yaw_deg) steer.yaw_rad = glm::radians(*yaw_deg);
    reader.optional("clip", steer.clip);
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return steer;
}

json actor_to_json(const ActorReport& actor) {
    const glm::dquat& q = actor.orientation;
    return {{"name", actor.name},
            {"id", actor.id},
            {"class", actor.object_class},
            {"model", actor.model},
            {"scale", actor.scale},
            {"position", {actor.position.x, actor.position.y, actor.position.z}},
            {"orientation", {q.x, q.y, q.z, q.w}},
            {"yaw_deg", glm::degrees(yaw_of(actor.orientation))},
            {"velocity", {actor.velocity.x, actor.velocity.y, actor.velocity.z}},
            {"behaviour", actor.behaviour},
            {"arrived", actor.arrived},
            {"clip", actor.clip},
            {"attached_to", actor.attached_to}};
}

}  // namespace camrig
