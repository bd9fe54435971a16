#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/result.h"
#include "core/base/unique_fd.h"

namespace camrig {

/// A recorded data set: a folder that is readable up to its last frame at any moment, however the recording ends.
///
///     dataset.json                     what was recorded: scene, cameras, picture format
///     CAMERA/truth.jsonl               the journal: the truth of one frame a line, as truth.get gives it
///     CAMERA/image_2/000001.png|jpg    pictures
///     CAMERA/label_2/000001.txt        KITTI labels           CAMERA/calib/000001.txt   KITTI calibration
///     CAMERA/gt/gt.txt, seqinfo.ini    MOTChallenge
///     CAMERA/camera_info.yaml          calibration for ROS    CAMERA/opencv.yml         for OpenCV
///     coco.json                        COCO, of all cameras: made by finish() from the journals
///
/// A frame counts when its line is in the journal, which is written last. Pictures and KITTI files are put in place
/// whole; MOT and journal lines are appended with one write each.
class DatasetWriter {
public:
    /// Makes the folder; refuses one that holds a data set already.
    static Result<DatasetWriter> create(const std::filesystem::path& folder, const nlohmann::json& description,
                                        const std::string& picture_suffix);

    /// Adds one frame of a camera; the first of a camera makes its folders and calibration.
    Result<void> add(const nlohmann::json& truth, std::span<const std::byte> picture, const std::string& frame_rate);

private:
    struct Camera {
        std::filesystem::path folder;
        std::int64_t frames = 0;
        UniqueFd journal, mot;
        std::string sequence_head;  ///< of seqinfo.ini, without the length
    };
    Result<Camera*> camera(const nlohmann::json& truth, const std::string& frame_rate);

    std::filesystem::path folder_;
    std::string picture_suffix_;
    std::vector<Camera> cameras_;
};

/// Makes coco.json and the MOTChallenge files from the journals; all a data set needs after its recording was killed.
/// Returns how many frames there are.
Result<std::int64_t> finish_dataset(const std::filesystem::path& folder);

}  // namespace camrig
