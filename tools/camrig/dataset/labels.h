#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

/// The labels of one frame as the common formats have them, from its truth as truth.get gives it (docs/truth.md says
/// what each number means). Pure; a truth that lacks a member throws nlohmann's exceptions.
namespace camrig::cli {

/// Lines of MOTChallenge's gt.txt: frame from 1, id, left, top, width, height (full box, the first pixel is 1), 1,
/// class, visibility. Only classes that MOTChallenge has.
std::string mot_lines(const nlohmann::json& truth, std::int64_t frame);

/// Lines of a KITTI object label file, for what is seen at all and has a KITTI type.
std::string kitti_lines(const nlohmann::json& truth);
/// KITTI's calib file: the four projection matrices are the camera's own, everything else is the identity.
std::string kitti_calibration(const nlohmann::json& truth);

/// Adds the classes of a world ({"person": 2, ...}) that a data set does not have yet, numbered on from those it has:
/// each world numbers its classes in its own way.
void add_classes(const nlohmann::json& of_world, nlohmann::json& of_set);

/// COCO's number of a class: its own where COCO knows the name, else 1000 and its number in `classes`.
int coco_category(const std::string& class_name, const nlohmann::json& classes);
/// The categories of classes ({"person": 2, ...}); people with their 17 keypoints and the skeleton.
nlohmann::json coco_categories(const nlohmann::json& classes);
/// One annotation for each object that is seen, with its mask where the truth has one; `next_id` counts on.
nlohmann::json coco_annotations(const nlohmann::json& truth, const nlohmann::json& classes, std::int64_t image_id,
                                std::int64_t& next_id);

/// Lines of a YOLO label file: class (its number in `classes` less one), middle, width and height of the visible box as
/// shares of the picture's size. For what is seen at all.
std::string yolo_lines(const nlohmann::json& truth, const nlohmann::json& classes);
/// The dataset file that YOLO's trainer takes: folders of pictures and names of classes ({"person": 2, ...}).
std::string yolo_description(const std::vector<std::string>& cameras, const nlohmann::json& classes);

/// OpenCV FileStorage YAML: image_width, image_height, camera_matrix, distortion_coefficients, fisheye_model.
std::string opencv_calibration(const nlohmann::json& truth);

}  // namespace camrig::cli
