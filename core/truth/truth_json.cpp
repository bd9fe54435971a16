#include "core/truth/truth_json.h"

#include "core/base/field_of.h"
#include "core/world/camera_json.h"

namespace camrig::truth {
namespace {

using nlohmann::json;

json array_of(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

json array_of(const glm::dquat& q) {
    return {q.x, q.y, q.z, q.w};
}

void add_keypoints(const ObjectTruth& object, json& to) {
    if (object.keypoints.empty()) return;
    json pixels = json::array(), places = json::array();
    for (const Keypoint& point : object.keypoints) {
        pixels.push_back({point.pixel.x, point.pixel.y, static_cast<int>(point.visibility)});
        places.push_back(point.is_known ? array_of(point.world) : json(nullptr));
    }
    to["keypoints"] = std::move(pixels);
    to["keypoints_world"] = std::move(places);
}

json object_json(const ObjectTruth& object) {
    const glm::dvec2 low = object.box_full_min, extent = object.box_full_max - object.box_full_min;
    json value{
        {"id", static_cast<std::uint32_t>(object.id)},
        {"name", object.name},
        {"class", object.object_class},
        {"class_number", object.class_number},
        {"box", object.box ? json{object.box->x, object.box->y, object.box->width, object.box->height} : json(nullptr)},
        {"box_full", {low.x, low.y, extent.x, extent.y}},
        {"clipped", object.is_clipped},
        {"truncated", object.truncated},
        {"pixels", object.pixels},
        {"pixels_alone", object.pixels_alone},
        {"visible_fraction", static_cast<double>(object.pixels) / static_cast<double>(object.pixels_alone)},
        {"occluded_by", object.occluded_by ? json(static_cast<std::uint32_t>(*object.occluded_by)) : json(nullptr)},
        {"position", array_of(object.position)},
        {"orientation", array_of(object.orientation)},
        {"center", array_of(object.center)},
        {"dimensions", array_of(object.dimensions)},
        {"velocity", array_of(object.velocity)}};
    add_keypoints(object, value);
    return value;
}

}  // namespace

json truth_to_json(const TruthOfFrame& truth) {
    json classes = json::object(), objects = json::array();
    for (const auto& [number, name] : truth.classes) classes[name] = number;
    for (const ObjectTruth& object : truth.objects) objects.push_back(object_json(object));
    const camera::Intrinsics& k = truth.intrinsics;
    json value{
        {"camera", truth.camera},
        {"sequence", truth.sequence},
        {"time_ns", truth.world_ns},
        {"monotonic_ns", truth.monotonic_ns},
        {"size", {truth.size.width, truth.size.height}},
        {"intrinsics", {{"fx", k.fx}, {"fy", k.fy}, {"cx", k.cx}, {"cy", k.cy}}},
        {"lens", world::lens_to_json(truth.lens)},
        {"pose", {{"position", array_of(truth.pose.position)}, {"orientation", array_of(truth.pose.orientation)}}},
        {"ptz", truth.head ? world::ptz_to_json(*truth.head) : json(nullptr)},
        {"classes", std::move(classes)},
        {"objects", std::move(objects)}};
    if (truth.sensor) value["sensor"] = write_fields(fields_of(std::type_identity<SensorReading>{}), *truth.sensor);
    if (truth.clock) {
        value["stamp_ns"] = truth.world_ns + truth.clock->stamp_error_ns;
        value["steady_ns"] = truth.monotonic_ns + truth.clock->steady_error_ns;
    }
    return value;
}

}  // namespace camrig::truth
