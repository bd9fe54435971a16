#include "core/truth/truth_json.h"

#include "core/base/field_of.h"
#include "core/fault/delivery.h"
#include "core/fault/mask.h"
#include "core/fault/sending.h"
#include "core/fault/standing.h"
#include "core/world/backdrop/backdrop.h"
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

json pose_json(const camera::Pose& pose) {
    return {{"position", array_of(pose.position)}, {"orientation", array_of(pose.orientation)}};
}

/// What was wrong with the bytes that have gone out to an output.
void add_harms(const fault::HarmLog::Entries& entries, json& way) {
    way["damaged"] = json::array();
    way["more_damaged"] = entries.left_out;
    for (const fault::HarmLog::Entry& one : entries.first) {
        json runs = json::array();
        for (const fault::Harm::Run& run : one.harm.first) runs.push_back({run.offset, run.bytes});
        way["damaged"].push_back({{"fault", one.harm.fault},
                                  {"kind", one.harm.kind},
                                  {"mode", one.harm.mode},
                                  {"size", one.harm.size},
                                  {"bytes", one.harm.bytes},
                                  {"runs", std::move(runs)},
                                  {"more_runs", one.harm.runs - one.harm.first.size()},
                                  {"times", one.times}});
    }
}

const char* fate_of(const TruthOfFrame& truth, fault::Output output, std::string_view name) {
    const fault::FrameFaults* const faults = truth.faults.get();
    if (faults && faults->is_dropped) return "dropped";
    if (truth.not_drawn) return "not_drawn";
    if (!faults) return "sent";
    if (is_disconnected(*faults, name) || (output == fault::Output::device && unplug_of(*faults)))
        return "disconnected";
    return is_stalled(*faults, name) ? "stalled" : "sent";
}

/// From this frame until the one with which it comes is due, so many later.
TimeNs late_ns(const TruthOfFrame& truth, std::int64_t frames) {
    if (frames == 0 || !truth.spec) return 0;
    const camera::ExposureTimes times = world::exposure_times_of(*truth.spec);
    return times.time_of_frame(times.frames_until(truth.world_ns) + frames - 1) - truth.world_ns;
}

/// What becomes of the frame on its way to readers of each kind of output.
json ways_json(const TruthOfFrame& truth) {
    const fault::FrameFaults none{};
    const fault::FrameFaults& faults = truth.faults ? *truth.faults : none;
    json ways = json::object();
    for (const auto& [output, name] : names_of(std::type_identity<fault::Output>{})) {
        if (output == fault::Output::any) continue;
        const std::int64_t frames = frames_late(faults, name);
        json& way = ways[std::string(name)];
        way = {{"fate", fate_of(truth, output, name)},
               {"late_frames", frames},
               {"late_ns", late_ns(truth, frames)},
               {"refuses", standing_of(faults).refuses(name)}};
        if (output == fault::Output::mjpeg) {
            const ImageSize size = other_size(faults, name, truth.size).value_or(truth.size);
            const auto wrong = part_error(faults);
            way["size"] = {size.width, size.height};
            way["bad_part"] = wrong ? json(to_string(*wrong)) : json(nullptr);
        }
        if (output == fault::Output::device) way["error_flag"] = has_buffer_error(faults);
        add_harms(faults.harms ? faults.harms->entries(name) : fault::HarmLog::Entries{}, way);
    }
    return ways;
}

/// What the camera does wrong, and what its readers get for that.
void add_faults(const TruthOfFrame& truth, json& to) {
    json faults = json::array();
    if (truth.faults) {
        for (const fault::FaultRef& one : truth.faults->active)
            faults.push_back({{"id", one->id},
                              {"kind", fault::name_of(one->kind)},
                              {"layer", to_string(fault::layer_of(one->kind))},
                              {"severity", one->severity},
                              {"since_ns", one->begin_ns},
                              {"until_ns", one->end_ns == max_time_ns ? json(nullptr) : json(one->end_ns)}});
    }
    to["faults"] = std::move(faults);
    to["outputs"] = ways_json(truth);
    to["not_drawn"] = truth.not_drawn ? json(*truth.not_drawn) : json(nullptr);
    to["delivered"] = !(truth.faults && truth.faults->is_dropped);
    to["covered_fraction"] = truth.faults ? fault::covered_fraction(*truth.faults, truth.size) : 0.0;
    to["focus_error_px"] = truth.faults ? fault::blur_radius_px(*truth.faults, truth.size) : 0.0;
    to["shown_sequence"] = truth.faults ? truth.faults->shown_sequence : truth.sequence;
}

/// What the camera sees that is a picture, and what truth does not know of it.
void add_backdrop(const TruthOfFrame& truth, json& to) {
    const world::Backdrop* const here = truth.spec != nullptr ? truth.spec->backdrop_here.get() : nullptr;
    to["depth_source"] = here != nullptr ? "proxy" : "render";
    to["backdrop"] = here != nullptr
                         ? json{{"kind", to_string(truth.spec->backdrop->kind)}, {"file", truth.spec->backdrop->file}}
                         : json(nullptr);
    to["backdrop_frame"] = truth.film ? json(truth.film->frame) : json(nullptr);
    to["backdrop_late"] = truth.film ? json(truth.film->late) : json(nullptr);
    to["ignore"] = json::array();
    if (here == nullptr) return;
    for (const world::IgnoredRegion& region : here->ignore) {
        json corners = json::array();
        for (const glm::dvec2& corner : region.polygon_px) corners.push_back({corner.x, corner.y});
        to["ignore"].push_back({{"polygon_px", std::move(corners)}, {"class", region.object_class}});
    }
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
        {"pixels_soiled", object.pixels_soiled},
        {"pixels_alone", object.pixels_alone},
        {"visible_fraction", static_cast<double>(object.pixels) / static_cast<double>(object.pixels_alone)},
        {"visible_fraction_soiled",
         static_cast<double>(object.pixels - object.pixels_soiled) / static_cast<double>(object.pixels_alone)},
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
    json value{{"camera", truth.camera},
               {"sequence", truth.sequence},
               {"time_ns", truth.world_ns},
               {"monotonic_ns", truth.monotonic_ns},
               {"size", {truth.size.width, truth.size.height}},
               {"intrinsics", {{"fx", k.fx}, {"fy", k.fy}, {"cx", k.cx}, {"cy", k.cy}}},
               {"lens", world::lens_to_json(truth.lens)},
               {"pose", pose_json(truth.pose)},
               {"pose_believed", pose_json(truth.believed_pose.value_or(truth.pose))},
               {"ptz", truth.head ? world::ptz_to_json(*truth.head) : json(nullptr)},
               {"classes", std::move(classes)},
               {"objects", std::move(objects)}};
    add_faults(truth, value);
    add_backdrop(truth, value);
    value["sensor"] =
        truth.sensor ? write_fields(fields_of(std::type_identity<SensorReading>{}), *truth.sensor) : json(nullptr);
    const auto of_sensor = [&](TimeNs SensorReading::* time) {
        return truth.sensor ? json((*truth.sensor).*time) : json(nullptr);
    };
    value["exposure_start_ns"] = of_sensor(&SensorReading::exposure_start_ns);
    value["exposure_end_ns"] = of_sensor(&SensorReading::exposure_end_ns);
    value["row_ns"] = of_sensor(&SensorReading::row_ns);
    value["clock"] = truth.spec && truth.spec->clock
                         ? write_fields(fields_of(std::type_identity<camera::ClockSpec>{}), *truth.spec->clock)
                         : json(nullptr);
    value["clock_now"] = nullptr;
    if (truth.clock && truth.spec && truth.spec->clock)
        value["clock_now"] = {{"state", to_string(truth.spec->clock->state)},
                              {"offset_ns", truth.clock->stamp_error_ns},
                              {"steady_offset_ns", truth.clock->steady_error_ns},
                              {"drift_ppb", truth.clock->drift_ppb}};
    if (truth.clock || truth.sensor) {
        const ClockReading clock = truth.clock.value_or(ClockReading{});
        const TimeNs taken_for_ns = truth.sensor ? truth.world_ns - truth.sensor->exposure_start_ns : 0;
        value["stamp_ns"] = truth.world_ns - taken_for_ns + clock.stamp_error_ns;
        value["steady_ns"] = truth.monotonic_ns - taken_for_ns + clock.steady_error_ns;
    }
    return value;
}

}  // namespace camrig::truth
