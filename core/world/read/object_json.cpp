#include "core/world/read/object_json.h"

#include "core/world/read/actor_json.h"
#include "core/world/world_fields.h"

namespace camrig::world {

using nlohmann::json;

const std::vector<FieldOf<ObjectSpec>>& spawned_object_fields() {
    static const std::vector<FieldOf<ObjectSpec>> table = [] {
        const auto& all = fields_of(std::type_identity<ObjectSpec>{});
        std::vector<FieldOf<ObjectSpec>> made(all.begin(), all.end());
        std::erase_if(made, [](const auto& entry) { return entry.field.name == "attach"; });
        return made;
    }();
    return table;
}

FieldTable<ObjectPatch> fields_of(std::type_identity<ObjectPatch>) {
    static const std::vector<FieldOf<ObjectPatch>> table = [] {
        std::vector<FieldOf<ObjectPatch>> made{
            name_at<&ObjectPatch::name>({.name = "name", .doc = "of the object or actor", .required = true}),
            field_at<&ObjectPatch::hidden>(
                {.name = "hidden",
                 .doc = "in no picture and no ground truth; casts no shadow, and goes on moving if it does"}),
            field_at<&ObjectPatch::scale>({.name = "scale", .doc = "of the model", .range = {1e-6, 1e6}}),
            vector_at<&ObjectPatch::position>(
                {.name = "position", .doc = "of its origin; not of actors, which actor.set places"})};
        add_orientation<&ObjectPatch::orientation>(made, "counter-clockwise from above; or orientation");
        return made;
    }();
    return table;
}

FieldTable<ObjectReport> fields_of(std::type_identity<ObjectReport>) {
    using Report = ObjectReport;
    static const std::vector<FieldOf<Report>> table{
        told_at<&Report::name>({.name = "name", .doc = "its name"}),
        told_at<&Report::id>({.name = "id", .doc = "its identity in pictures of kind `instance` and in ground truth"}),
        told_at<&Report::object_class>({.name = "class", .doc = "what ground truth calls it"}),
        told_at<&Report::model>({.name = "model", .doc = "of the scene"}),
        told_at<&Report::moves>({.name = "moves", .doc = "an actor, or an object that plays a clip or was picked up"}),
        told_at<&Report::hidden>({.name = "hidden", .doc = "as object.set says"}),
        told_at<&Report::scale>({.name = "scale", .doc = "of the model"}),
        {.field = {.name = "position", .type = "[x, y, z]", .doc = "of its origin", .unit = "m"},
         .write =
             [](const Report& object) {
                 const glm::dvec3& v = object.position;
                 return json{v.x, v.y, v.z};
             }},
        {.field = {.name = "orientation", .type = "[x, y, z, w]", .doc = "of an actor: its front is +x"},
         .write = [](const Report& object) {
             const glm::dquat& q = object.orientation;
             return json{q.x, q.y, q.z, q.w};
         }}};
    return table;
}

}  // namespace camrig::world
