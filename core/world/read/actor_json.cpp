#include "core/world/read/actor_json.h"

#include "core/world/read/behaviour_json.h"
#include "core/world/turn.h"
#include "core/world/world_fields.h"

namespace camrig::world {

using nlohmann::json;

namespace {

template <auto member>
auto behaviour_at(std::string fallback = {}) {
    return nested_at<member>({.name = "behaviour",
                              .doc = "see behaviours",
                              .fallback = std::move(fallback),
                              .shape = "Behaviour",
                              .schema = R"({"$ref": "#/$defs/behaviour"})"},
                             read_behaviour);
}

template <auto member>
auto attachment_at() {
    return field_at<member>({.name = "attach",
                             .doc = "hangs it on a node of another actor: {actor, node, position, yaw_deg or "
                                    "orientation}",
                             .shape = "Attachment",
                             .schema = R"({"$ref": "#/$defs/attachment"})"});
}

template <auto member>
auto variant_at(std::string fallback) {
    return field_at<member>({.name = "variant",
                             .doc = "which of the looks of its model: colors and what it wears follow from this number",
                             .fallback = std::move(fallback),
                             .range = {.low = 0}});
}

/// What objects and actors have: what it is, and where.
template <typename T>
std::vector<FieldOf<T>> thing_fields(std::string position, std::string yaw) {
    std::vector<FieldOf<T>> made{
        name_at<&T::name>(
            {.name = "name", .doc = "unique among objects and actors; its name in ground truth", .required = true}),
        field_at<&T::model>({.name = "model", .doc = "a name of `models` of the scene", .required = true}),
        name_at<&T::object_class>(
            {.name = "class", .doc = "what ground truth calls it, as `person`", .fallback = "object"}),
        vector_at<&T::position>({.name = "position", .doc = std::move(position), .fallback = "[0, 0, 0]"})};
    add_orientation<&T::orientation>(made, yaw);
    made.push_back(field_at<&T::scale>({.name = "scale", .doc = "of the model", .range = {1e-6, 1e6}}));
    return made;
}

/// A vector that is told and never taken.
template <auto member>
FieldOf<ActorReport> told_vector(Field field) {
    field.type = "[x, y, z]";
    return {.field = std::move(field), .write = [](const ActorReport& actor) {
                const glm::dvec3& v = actor.*member;
                return json{v.x, v.y, v.z};
            }};
}

}  // namespace

FieldTable<Attachment> fields_of(std::type_identity<Attachment>) {
    static const std::vector<FieldOf<Attachment>> table = [] {
        std::vector<FieldOf<Attachment>> made{
            name_at<&Attachment::actor>({.name = "actor", .doc = "that carries it", .required = true}),
            field_at<&Attachment::node>({.name = "node", .doc = "of its model; none: its origin", .fallback = "none"}),
            vector_at<&Attachment::position>({.name = "position", .doc = "from there", .fallback = "[0, 0, 0]"})};
        add_orientation<&Attachment::orientation>(made, "turn about z of the node");
        return made;
    }();
    return table;
}

FieldTable<ObjectSpec> fields_of(std::type_identity<ObjectSpec>) {
    static const std::vector<FieldOf<ObjectSpec>> table = [] {
        auto made = thing_fields<ObjectSpec>("of its origin", "counter-clockwise from above; or orientation");
        made.push_back(field_at<&ObjectSpec::clip>(
            {.name = "clip", .doc = "an animation of the model, played in a loop", .fallback = "none: the rest pose"}));
        made.push_back(attachment_at<&ObjectSpec::attach>());
        return made;
    }();
    return table;
}

FieldTable<ActorSpec> fields_of(std::type_identity<ActorSpec>) {
    static const std::vector<FieldOf<ActorSpec>> table = [] {
        auto made = thing_fields<ActorSpec>("of its origin; where a route does not place it",
                                            "where its front looks, counter-clockwise from +x; or orientation");
        made.push_back(variant_at<&ActorSpec::variant>("none: as its file has it"));
        made.push_back(field_at<&ActorSpec::radius_m>({.name = "radius_m",
                                                       .doc = "of its body, for those who walk round it",
                                                       .unit = "m",
                                                       .fallback = "0.28 for class person, else 0",
                                                       .range = {0.0, 100.0}}));
        made.push_back(attachment_at<&ActorSpec::attach>());
        made.push_back(behaviour_at<&ActorSpec::behaviour>(R"({"type": "stand"})"));
        return made;
    }();
    return table;
}

FieldTable<ActorPatch> fields_of(std::type_identity<ActorPatch>) {
    static const std::vector<FieldOf<ActorPatch>> table = [] {
        std::vector<FieldOf<ActorPatch>> made{
            name_at<&ActorPatch::name>({.name = "name", .doc = "name of the actor", .required = true}),
            vector_at<&ActorPatch::position>({.name = "position", .doc = "of its origin"})};
        add_orientation<&ActorPatch::orientation>(made,
                                                  "where its front looks, counter-clockwise from +x; or orientation");
        made.push_back(variant_at<&ActorPatch::variant>(""));
        made.push_back(behaviour_at<&ActorPatch::behaviour>());
        made.push_back(attachment_at<&ActorPatch::attach>());
        made.push_back(field_at<&ActorPatch::detach>({.name = "detach", .doc = "no longer hangs on anything"}));
        made.push_back(field_at<&ActorPatch::play>(
            {.name = "play", .doc = "a clip over the one of the behaviour; empty: no longer"}));
        made.push_back(
            field_at<&ActorPatch::play_speed>({.name = "play_speed", .doc = "of that clip", .range = {0.0, 100.0}}));
        return made;
    }();
    return table;
}

FieldTable<SteerSpec> fields_of(std::type_identity<SteerSpec>) {
    static const std::vector<FieldOf<SteerSpec>> table{
        name_at<&SteerSpec::name>({.name = "name", .doc = "name of the actor", .required = true}),
        vector_at<&SteerSpec::velocity>({.name = "velocity", .doc = "held until it is told another", .unit = "m/s"}),
        vector_at<&SteerSpec::position>({.name = "position", .doc = "instead of a velocity: reached after `seconds`"}),
        seconds_at<&SteerSpec::over_ns>({.name = "seconds", .fallback = "0: at once", .range = {0.0, 3600.0}}),
        degrees_at<&SteerSpec::yaw_rad>(
            {.name = "yaw_deg", .doc = "where its front looks", .fallback = "the way it moves"}),
        field_at<&SteerSpec::clip>({.name = "clip", .doc = "that it plays", .fallback = "as it is"})};
    return table;
}

FieldTable<ActorReport> fields_of(std::type_identity<ActorReport>) {
    using Report = ActorReport;
    static const std::vector<FieldOf<Report>> table{
        told_at<&Report::name>({.name = "name", .doc = "its name"}),
        told_at<&Report::id>({.name = "id", .doc = "its identity in ground truth, in all cameras"}),
        told_at<&Report::object_class>({.name = "class", .doc = "what ground truth calls it"}),
        told_at<&Report::model>({.name = "model", .doc = "of the scene"}),
        told_at<&Report::scale>({.name = "scale", .doc = "of the model"}),
        told_at<&Report::variant>({.name = "variant",
                                   .doc = "which of the looks of its model",
                                   .range = {.low = 0},
                                   .null = "as its file has it"}),
        told_vector<&Report::position>(
            {.name = "position", .doc = "of its origin, at the world's last step", .unit = "m"}),
        {.field = {.name = "orientation", .type = "[x, y, z, w]", .doc = "of the actor: its front is +x"},
         .write =
             [](const Report& actor) {
                 const glm::dquat& q = actor.orientation;
                 return json{q.x, q.y, q.z, q.w};
             }},
        {.field =
             {.name = "yaw_deg", .type = "number", .doc = "of its front, counter-clockwise from +x", .unit = "deg"},
         .write = [](const Report& actor) { return json(glm::degrees(yaw_of(actor.orientation))); }},
        told_vector<&Report::velocity>({.name = "velocity", .doc = "over the last step", .unit = "m/s"}),
        told_at<&Report::behaviour>({.name = "behaviour", .doc = "type of its behaviour"}),
        told_at<&Report::arrived>({.name = "arrived", .doc = "whether it has done what its behaviour is to do"}),
        told_at<&Report::clip>({.name = "clip", .doc = "the clip it plays; empty: none"}),
        told_at<&Report::attached_to>({.name = "attached_to", .doc = "the actor that it hangs on; empty: none"})};
    return table;
}

Result<ActorSpec> read_actor(JsonReader& reader) {
    return read_all<ActorSpec>(reader, [](const ActorSpec& actor, JsonReader& keys) {
        const bool is_placed = keys.has("position") || keys.has("yaw_deg") || keys.has("orientation");
        if (is_placed && places_actor(actor.behaviour))
            keys.fail("position", "its route places this actor; leave position and orientation out");
    });
}

Result<ActorPatch> read_actor_patch(JsonReader& reader) {
    return read_all<ActorPatch>(reader, [](const ActorPatch& patch, JsonReader& keys) {
        if (patch.attach && patch.detach) keys.fail("detach", "give either attach or detach");
    });
}

Result<SteerSpec> read_steer(const json& value, const std::string& path) {
    return read_all<SteerSpec>(value, path, [](const SteerSpec& steer, JsonReader& keys) {
        if (steer.velocity && glm::length(*steer.velocity) > max_speed_m_s)
            keys.fail("velocity", "expected at most 1000 m/s");
        if (steer.velocity && steer.position) keys.fail("position", "give either velocity or position");
        if (keys.has("seconds") && !steer.position) keys.fail("seconds", "belongs to a position");
    });
}

}  // namespace camrig::world
