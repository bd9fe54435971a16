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

namespace camrig::cli {

/// A recorded data set: a folder that is readable up to its last frame at any moment, however the recording ends.
///
///     dataset.json                     what was recorded: scene, cameras, picture format
///     CAMERA/truth.jsonl               the journal: the truth of one frame a line, as truth.get gives it
///     CAMERA/image_2/000001.png|jpg    pictures
///     CAMERA/label_2/000001.txt        KITTI labels           CAMERA/calib/000001.txt   KITTI calibration
///     CAMERA/gt/gt.txt, seqinfo.ini    MOTChallenge
///     CAMERA/camera_info.yaml          calibration for ROS    CAMERA/opencv.yml         for OpenCV
///     CAMERA/labels/000001.txt         YOLO, where it is asked for; then image_2 leads to CAMERA/images, where YOLO
///     looks CAMERA/depth, flow, instance, soiling   further pictures of each frame, as the caller gives them
///     coco.json, yolo.yaml             COCO and YOLO's description, of all cameras: made by finish_dataset() from the
///                                      journals
///
/// A frame counts when its line is in the journal, which is written last. Pictures and labels of a frame are put in
/// place whole; MOT and journal lines are appended whole or not at all. What a frame that failed has left is removed.
class DatasetWriter {
public:
    /// One file of a frame: CAMERA/folder/000001suffix.
    struct FrameFile {
        std::string folder;
        std::string suffix;
        std::vector<std::byte> bytes;
    };

    /// Makes the folder; refuses one that holds a data set already. description: what dataset.json is to say; "yolo"
    /// true asks for YOLO labels.
    static Result<DatasetWriter> create(const std::filesystem::path& folder, const nlohmann::json& description,
                                        const std::string& picture_suffix);

    /// Adds one frame of a camera; the first of a camera makes its folders and calibration. `further`: depth, flow,
    /// instance, soiling.
    Result<void> add(const nlohmann::json& truth, std::span<const std::byte> picture,
                     const std::vector<FrameFile>& further, const std::string& frame_rate);

private:
    /// A file of lines, each of which is there whole or not at all.
    struct LineFile {
        std::filesystem::path path;
        UniqueFd fd;
        std::int64_t size = 0;

        static Result<LineFile> open(const std::filesystem::path& path);
        Result<void> append(const std::string& lines);
        void cut_back(std::int64_t to_size);
    };
    struct Camera {
        std::filesystem::path folder;
        std::int64_t frames = 0;
        LineFile journal, mot;
        std::string sequence_head;  ///< of seqinfo.ini, without the length
    };
    Result<Camera*> camera(const nlohmann::json& truth, const std::string& frame_rate);
    Result<void> add_files(Camera& to, const nlohmann::json& truth, std::span<const std::byte> picture,
                           const std::vector<FrameFile>& further, std::int64_t frame) const;

    std::filesystem::path folder_;
    std::string picture_suffix_;
    bool with_yolo_ = false;
    std::vector<Camera> cameras_;
};

/// Makes coco.json, yolo.yaml and the MOTChallenge files from the journals, cuts off a journal's last line if it is not
/// whole and removes pictures and labels of frames that the journal does not have: all a data set needs after its
/// recording was killed, or its disk was full. Returns how many frames there are.
Result<std::int64_t> finish_dataset(const std::filesystem::path& folder);

}  // namespace camrig::cli
