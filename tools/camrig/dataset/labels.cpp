#include "tools/camrig/dataset/labels.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/camera/pose.h"
#include "core/truth/keypoints.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

// MOT16, table 3 of its paper: 1 pedestrian, 3 car, 4 bicycle, 5 motorbike.
const std::map<std::string, int> mot_classes{
    {"person", 1}, {"car", 3}, {"vehicle", 3}, {"bicycle", 4}, {"motorcycle", 5}};
const std::map<std::string, std::string> kitti_types{{"person", "Pedestrian"}, {"car", "Car"},     {"vehicle", "Car"},
                                                     {"van", "Van"},           {"truck", "Truck"}, {"tram", "Tram"}};
const std::map<std::string, int> coco_numbers{
    {"person", 1},    {"bicycle", 2},   {"car", 3},    {"motorcycle", 4},     {"airplane", 5},
    {"bus", 6},       {"train", 7},     {"truck", 8},  {"traffic light", 10}, {"bench", 15},
    {"backpack", 27}, {"suitcase", 33}, {"chair", 62}, {"couch", 63},         {"potted plant", 64}};
constexpr int first_own_category = 1000;

template <typename... Numbers>
std::string format(const char* pattern, Numbers... numbers) {
    char text[512];
    const int length = std::snprintf(text, sizeof text, pattern, numbers...);
    return {text, static_cast<std::size_t>(std::clamp(length, 0, static_cast<int>(sizeof text) - 1))};
}

glm::dvec3 vector_of(const json& value) {
    return {value.at(0).get<double>(), value.at(1).get<double>(), value.at(2).get<double>()};
}

glm::dquat quaternion_of(const json& value) {
    return {value.at(3).get<double>(), value.at(0).get<double>(), value.at(1).get<double>(), value.at(2).get<double>()};
}

/// KITTI's levels: 0 fully visible, 1 partly occluded, 2 largely occluded.
int kitti_occlusion(double visible_fraction) {
    if (visible_fraction >= 0.9) return 0;
    return visible_fraction >= 0.5 ? 1 : 2;
}

json skeleton() {
    // As in COCO's person_keypoints annotations, numbers from 1.
    return {{16, 14}, {14, 12}, {17, 15}, {15, 13}, {12, 13}, {6, 12}, {7, 13}, {6, 7}, {6, 8}, {7, 9},
            {8, 10},  {9, 11},  {2, 3},   {1, 2},   {1, 3},   {2, 4},  {3, 5},  {4, 6}, {5, 7}};
}

}  // namespace

std::string mot_lines(const json& truth, std::int64_t frame) {
    std::string lines;
    for (const json& object : truth.at("objects")) {
        const auto known = mot_classes.find(object.at("class").get<std::string>());
        if (known == mot_classes.end()) continue;
        const json& box = object.at("box_full");
        // From centres at integers to MOTChallenge's edges, where the first pixel reaches from 1 to 2.
        lines += format("%lld,%u,%.2f,%.2f,%.2f,%.2f,1,%d,%.5f\n", static_cast<long long>(frame),
                        object.at("id").get<unsigned>(), box.at(0).get<double>() + 1.5, box.at(1).get<double>() + 1.5,
                        box.at(2).get<double>(), box.at(3).get<double>(), known->second,
                        object.at("visible_fraction").get<double>());
    }
    return lines;
}

std::string kitti_lines(const json& truth) {
    const camera::Pose camera{vector_of(truth.at("pose").at("position")),
                              quaternion_of(truth.at("pose").at("orientation"))};
    const glm::dmat3 optical_from_world = glm::transpose(world_from_optical_rotation(camera));
    const double right_end = truth.at("size").at(0).get<double>() - 1.0;
    const double bottom_end = truth.at("size").at(1).get<double>() - 1.0;
    std::string lines;
    for (const json& object : truth.at("objects")) {
        const auto type = kitti_types.find(object.at("class").get<std::string>());
        if (type == kitti_types.end() || object.at("pixels").get<std::int64_t>() == 0) continue;
        const json& box = object.at("box_full");
        const double left = box.at(0).get<double>(), top = box.at(1).get<double>();
        const glm::dvec3 size = vector_of(object.at("dimensions"));
        const glm::dmat3 world_from_object = glm::mat3_cast(quaternion_of(object.at("orientation")));
        const glm::dvec3 foot = vector_of(object.at("center")) - 0.5 * size.z * world_from_object[2];
        const glm::dvec3 place = optical_from_world * (foot - camera.position);
        const glm::dvec3 ahead = optical_from_world * world_from_object[0];
        const double rotation_y = std::atan2(-ahead.z, ahead.x);
        const double alpha = std::remainder(rotation_y - std::atan2(place.x, place.z), 2.0 * std::numbers::pi);
        lines +=
            format("%s %.2f %d %.4f %.2f %.2f %.2f %.2f %.3f %.3f %.3f %.3f %.3f %.3f %.4f\n", type->second.c_str(),
                   object.at("truncated").get<double>(), kitti_occlusion(object.at("visible_fraction").get<double>()),
                   alpha, std::clamp(left, 0.0, right_end), std::clamp(top, 0.0, bottom_end),
                   std::clamp(left + box.at(2).get<double>(), 0.0, right_end),
                   std::clamp(top + box.at(3).get<double>(), 0.0, bottom_end), size.z, size.y, size.x, place.x, place.y,
                   place.z, rotation_y);
    }
    return lines;
}

std::string kitti_calibration(const json& truth) {
    const json& k = truth.at("intrinsics");
    const std::string matrix = format("%.12e 0 %.12e 0 0 %.12e %.12e 0 0 0 1 0\n", k.at("fx").get<double>(),
                                      k.at("cx").get<double>(), k.at("fy").get<double>(), k.at("cy").get<double>());
    std::string text;
    for (int i = 0; i < 4; ++i) text += "P" + std::to_string(i) + ": " + matrix;
    text += "R0_rect: 1 0 0 0 1 0 0 0 1\n";
    for (const char* name : {"Tr_velo_to_cam", "Tr_imu_to_velo"})
        text += name + std::string(": 1 0 0 0 0 1 0 0 0 0 1 0\n");
    return text;
}

void add_classes(const json& of_world, json& of_set) {
    std::map<int, std::string> names;
    for (const auto& [name, number] : of_world.items()) names[number.get<int>()] = name;
    for (const auto& [number, name] : names)
        if (!of_set.contains(name)) of_set.emplace(name, of_set.size() + 1);
}

int coco_category(const std::string& class_name, const json& classes) {
    const auto known = coco_numbers.find(class_name);
    return known == coco_numbers.end() ? first_own_category + classes.at(class_name).get<int>() : known->second;
}

json coco_categories(const json& classes) {
    json categories = json::array();
    for (const auto& [name, number] : classes.items()) {
        json category{{"id", coco_category(name, classes)}, {"name", name}, {"supercategory", name}};
        if (name == "person") {
            category["keypoints"] = truth::coco_keypoints;
            category["skeleton"] = skeleton();
        }
        categories.push_back(std::move(category));
    }
    return categories;
}

namespace {

/// Where a backdrop shows somebody whom nobody labels: who finds them is neither right nor wrong.
void add_ignored(const json& truth, const json& classes, std::int64_t image_id, std::int64_t& next_id,
                 json& annotations) {
    for (const json& region : truth.value("ignore", json::array())) {
        const std::string name = region.at("class");
        if (!classes.contains(name)) continue;
        // From centres at integers to COCO's edges.
        double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
        json outline = json::array();
        for (const json& corner : region.at("polygon_px")) {
            for (std::size_t axis = 0; axis < 2; ++axis) {
                const double at = corner.at(axis).get<double>() + 0.5;
                low[axis] = std::min(low[axis], at);
                high[axis] = std::max(high[axis], at);
                outline.push_back(at);
            }
        }
        const double width = high[0] - low[0], height = high[1] - low[1];
        annotations.push_back({{"id", next_id++},
                               {"image_id", image_id},
                               {"category_id", coco_category(name, classes)},
                               {"bbox", {low[0], low[1], width, height}},
                               {"area", width * height},
                               {"iscrowd", 1},
                               {"segmentation", json::array({std::move(outline)})}});
    }
}

}  // namespace

json coco_annotations(const json& truth, const json& classes, std::int64_t image_id, std::int64_t& next_id) {
    json annotations = json::array();
    add_ignored(truth, classes, image_id, next_id, annotations);
    for (const json& object : truth.at("objects")) {
        if (object.at("pixels").get<std::int64_t>() == 0) continue;
        json annotation{{"id", next_id++},
                        {"image_id", image_id},
                        {"category_id", coco_category(object.at("class"), classes)},
                        {"bbox", object.at("box")},
                        {"area", object.at("pixels")},
                        {"iscrowd", 0},
                        {"segmentation", object.value("segmentation", json::array())},
                        {"track_id", object.at("id")},
                        {"visible_fraction", object.at("visible_fraction")},
                        {"truncated", object.at("truncated")}};
        if (object.contains("keypoints")) {
            json points = json::array();
            int known = 0;
            for (const json& point : object.at("keypoints")) {
                const int visibility = point.at(2).get<int>();
                known += visibility > 0;
                points.push_back(visibility > 0 ? point.at(0) : json(0));
                points.push_back(visibility > 0 ? point.at(1) : json(0));
                points.push_back(visibility);
            }
            annotation["keypoints"] = std::move(points);
            annotation["num_keypoints"] = known;
        }
        annotations.push_back(std::move(annotation));
    }
    return annotations;
}

std::string yolo_lines(const json& truth, const json& classes) {
    const double width = truth.at("size").at(0).get<double>(), height = truth.at("size").at(1).get<double>();
    std::string lines;
    for (const json& object : truth.at("objects")) {
        if (object.at("pixels").get<std::int64_t>() == 0) continue;
        const json& box = object.at("box");
        const double w = box.at(2).get<double>(), h = box.at(3).get<double>();
        lines += format("%d %.6f %.6f %.6f %.6f\n", classes.at(object.at("class").get<std::string>()).get<int>() - 1,
                        (box.at(0).get<double>() + w / 2.0) / width, (box.at(1).get<double>() + h / 2.0) / height,
                        w / width, h / height);
    }
    return lines;
}

std::string yolo_description(const std::vector<std::string>& cameras, const json& classes) {
    json folders = json::array();
    for (const std::string& camera : cameras) folders.push_back(camera + "/images");
    std::map<int, std::string> names;
    for (const auto& [name, number] : classes.items()) names[number.get<int>() - 1] = name;
    std::string text = "train: " + folders.dump() + "\nval: " + folders.dump() + "\nnames:\n";
    for (const auto& [number, name] : names) text += "  " + std::to_string(number) + ": " + json(name).dump() + "\n";
    return text;
}

std::string opencv_calibration(const json& truth) {
    const json& k = truth.at("intrinsics");
    std::vector<double> coefficients = truth.at("lens").at("coefficients").get<std::vector<double>>();
    if (coefficients.empty()) coefficients.assign(5, 0.0);
    std::string numbers;
    for (const double value : coefficients) numbers += (numbers.empty() ? "" : ", ") + format("%.17g", value);
    return format(
               "%%YAML:1.0\n---\nimage_width: %d\nimage_height: %d\ncamera_matrix: !!opencv-matrix\n   rows: 3\n"
               "   cols: 3\n   dt: d\n   data: [ %.17g, 0., %.17g, 0., %.17g, %.17g, 0., 0., 1. ]\n",
               truth.at("size").at(0).get<int>(), truth.at("size").at(1).get<int>(), k.at("fx").get<double>(),
               k.at("cx").get<double>(), k.at("fy").get<double>(), k.at("cy").get<double>()) +
           "distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: " + std::to_string(coefficients.size()) +
           "\n   dt: d\n   data: [ " + numbers +
           " ]\nfisheye_model: " + (truth.at("lens").at("model") == "equidistant" ? "1" : "0") + "\n";
}

}  // namespace camrig::cli
