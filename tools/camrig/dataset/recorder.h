#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "control/client/rpc_client.h"
#include "core/base/rate.h"
#include "core/camera/exposure_times.h"
#include "tools/camrig/cli_context.h"
#include "tools/camrig/dataset/dataset.h"

namespace camrig::cli {

/// What a data set has, and of which part of the world.
struct RecordOptions {
    std::filesystem::path folder;
    std::vector<std::string> cameras;    ///< empty: all
    std::optional<double> seconds;       ///< of world time
    std::optional<std::int64_t> frames;  ///< instants instead of seconds
    std::string format = "png";          ///< of the pictures: png or jpeg
    std::string depth;                   ///< npy, png, or empty: none
    bool flow = false;
    bool masks = false;
    bool soiling = false;
    bool yolo = false;
};

/// Writes a data set as a client like any other: it steps the world from one due instant to the next and takes picture
/// and truth of every camera that is due there, so that nothing is dropped however long a frame takes.
class Recorder {
public:
    /// Asked and told after each instant: how much is done (0..1), how many frames there are. False: that is enough.
    using GoesOn = std::function<bool(double share, std::int64_t frames)>;

    Recorder(const CliContext& context, client::RpcClient client, const RecordOptions& options)
        : context_(context), client_(std::move(client)), options_(options) {}

    /// A world that runs stands meanwhile, and runs on after it; what came before an error is a data set too.
    /// @return folder, cameras, frames
    Result<nlohmann::json> run(const GoesOn& goes_on);

private:
    struct Camera {
        std::string name;
        Rate rate;
        camera::ExposureTimes times;

        TimeNs next_due_ns(TimeNs after_ns) const { return times.time_of_frame(times.frames_until(after_ns)); }
    };

    Result<void> choose_cameras();
    Result<void> hold_world();
    Result<void> let_world_go();
    Result<void> begin_dataset();
    Result<std::map<std::string, TimeNs>> shown_after(TimeNs world_ns);
    Result<std::int64_t> record(const GoesOn& goes_on);
    Result<void> take(const Camera& camera, TimeNs instant_ns);
    Result<std::vector<std::byte>> picture(nlohmann::json params, const nlohmann::json& truth);
    Result<DatasetWriter::FrameFile> depth(const nlohmann::json& truth);
    Result<DatasetWriter::FrameFile> flow(const nlohmann::json& truth);
    Result<DatasetWriter::FrameFile> soiling(const nlohmann::json& truth);
    Result<DatasetWriter::FrameFile> masks(nlohmann::json& truth);

    const CliContext& context_;
    client::RpcClient client_;
    const RecordOptions& options_;
    std::vector<Camera> cameras_;
    std::optional<DatasetWriter> writer_;
    nlohmann::json names_ = nlohmann::json::array();
    nlohmann::json world_;
    bool resumes_ = false;
};

}  // namespace camrig::cli
