#include "tools/camrig/dataset/dataset.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <unistd.h>

#include "core/base/write_file.h"
#include "core/camera/calibration_file.h"
#include "tools/camrig/dataset/labels.h"

namespace camrig {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr const char* description_name = "dataset.json";
constexpr const char* journal_name = "truth.jsonl";

std::span<const std::byte> bytes_of_text(const std::string& text) {
    return std::as_bytes(std::span(text));
}

std::string frame_name(std::int64_t frame) {
    char text[32];
    std::snprintf(text, sizeof text, "%06lld", static_cast<long long>(frame));
    return text;
}

Error io_error(const fs::path& file, const char* what) {
    return {ErrorKind::unavailable, file.string() + ": cannot be " + what + ": " + std::strerror(errno)};
}

Result<void> make_folders(const fs::path& folder) {
    std::error_code failed;
    fs::create_directories(folder, failed);
    if (failed) return error(ErrorKind::unavailable, folder.string() + ": cannot be made: " + failed.message());
    return {};
}

/// One write, so that a reader never sees a part of what belongs together.
Result<void> append(const UniqueFd& fd, const fs::path& file, const std::string& text) {
    if (text.empty()) return {};
    const ssize_t count = ::write(fd.get(), text.data(), text.size());
    if (count != static_cast<ssize_t>(text.size())) return std::unexpected(io_error(file, "written"));
    return {};
}

Result<UniqueFd> open_to_append(const fs::path& file) {
    UniqueFd fd(::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
    if (!fd) return std::unexpected(io_error(file, "opened"));
    return fd;
}

Result<std::string> ros_calibration(const json& truth) {
    Calibration calibration;
    calibration.camera_name = truth.at("camera").get<std::string>();
    calibration.size = {truth.at("size").at(0).get<int>(), truth.at("size").at(1).get<int>()};
    const json& k = truth.at("intrinsics");
    calibration.intrinsics = {k.at("fx").get<double>(), k.at("fy").get<double>(), k.at("cx").get<double>(),
                              k.at("cy").get<double>()};
    auto model = parse_lens_model(truth.at("lens").at("model").get<std::string>());
    if (!model) return std::unexpected(model.error());
    calibration.lens.model = *model;
    const json& coefficients = truth.at("lens").at("coefficients");
    for (std::size_t i = 0; i < coefficients.size() && i < calibration.lens.coefficients.size(); ++i)
        calibration.lens.coefficients[i] = coefficients[i].get<double>();
    return write_camera_info(calibration);
}

/// Calls `each(truth, frame)` for every whole line of a journal; a line that was cut off in its middle ends it.
template <typename Each>
Result<std::int64_t> read_journal(const fs::path& file, Each&& each) {
    std::ifstream journal(file, std::ios::binary);
    if (!journal) return error(ErrorKind::not_found, file.string() + ": cannot be read");
    std::string line;
    std::int64_t frame = 0;
    while (std::getline(journal, line) && !journal.eof()) {
        const json truth = json::parse(line, nullptr, false);
        if (truth.is_discarded()) break;
        ++frame;
        if (Result<void> done = each(truth, frame); !done) return std::unexpected(done.error());
    }
    return frame;
}

json coco_image(const json& truth, const std::string& camera, const std::string& suffix, std::int64_t image_id,
                std::int64_t frame) {
    return {{"id", image_id},
            {"file_name", camera + "/image_2/" + frame_name(frame) + suffix},
            {"width", truth.at("size").at(0)},
            {"height", truth.at("size").at(1)},
            {"camera", camera},
            {"frame", frame},
            {"sequence", truth.at("sequence")},
            {"time_ns", truth.at("time_ns")}};
}

Result<json> read_description(const fs::path& folder) {
    std::ifstream file(folder / description_name);
    const json description = file ? json::parse(file, nullptr, false) : json(json::value_t::discarded);
    if (description.is_discarded() || !description.contains("cameras") || !description.contains("picture_suffix"))
        return error(ErrorKind::not_found, folder.string() + " holds no data set of camrig record (no sound " +
                                               std::string(description_name) + ")");
    return description;
}

/// COCO as a stream: the journals are read twice, so that memory does not grow with the recording.
Result<std::int64_t> write_coco(const fs::path& folder, const json& description, const fs::path& to) {
    std::ofstream out(to, std::ios::binary);
    const std::string suffix = description["picture_suffix"];
    std::int64_t frames = 0, annotation_id = 1;
    json classes = json::object();
    for (const bool for_images : {true, false}) {
        out << (for_images ? "{\"info\": " + json{{"description", "recorded by camrig"}}.dump() + ",\n\"images\": ["
                           : "],\n\"categories\": " + coco_categories(classes).dump() + ",\n\"annotations\": [");
        bool is_first = true;
        std::int64_t image_id = 0;
        for (const json& camera : description["cameras"]) {
            const fs::path journal = folder / camera.get<std::string>() / journal_name;
            if (!fs::exists(journal)) continue;  // killed before its first frame
            const auto read = read_journal(journal, [&](const json& truth, std::int64_t frame) -> Result<void> {
                ++image_id;
                const auto put = [&](const json& value) {
                    out << (is_first ? "\n" : ",\n") << value.dump();
                    is_first = false;
                };
                if (for_images) {
                    for (const auto& [name, number] : truth.at("classes").items()) classes[name] = number;
                    put(coco_image(truth, camera, suffix, image_id, frame));
                } else {
                    for (const json& annotation : coco_annotations(truth, image_id, annotation_id)) put(annotation);
                }
                return {};
            });
            if (!read) return std::unexpected(read.error());
        }
        frames = image_id;
    }
    out << "]}\n";
    out.close();
    if (!out) return std::unexpected(io_error(to, "written"));
    return frames;
}

std::string sequence_info(const std::string& head, std::int64_t frames) {
    return head + "seqLength=" + std::to_string(frames) + "\n";
}

/// The MOTChallenge files from the journal: a killed recording may have labels of a frame that it did not complete.
Result<void> rewrite_mot(const fs::path& folder) {
    std::string lines;
    const auto frames = read_journal(folder / journal_name, [&](const json& truth, std::int64_t frame) -> Result<void> {
        lines += mot_lines(truth, frame);
        return {};
    });
    if (!frames) return std::unexpected(frames.error());
    if (auto done = write_atomically(folder / "gt" / "gt.txt", bytes_of_text(lines)); !done) return done;
    std::ifstream info(folder / "seqinfo.ini");
    std::string head;
    for (std::string line; std::getline(info, line);)
        if (!line.starts_with("seqLength=")) head += line + "\n";
    return write_atomically(folder / "seqinfo.ini", bytes_of_text(sequence_info(head, *frames)));
}

}  // namespace

Result<DatasetWriter> DatasetWriter::create(const fs::path& folder, const json& description,
                                            const std::string& picture_suffix) {
    if (fs::exists(folder / description_name))
        return error(ErrorKind::already_exists, folder.string() + " holds a data set; give another folder");
    if (auto made = make_folders(folder); !made) return std::unexpected(made.error());
    json written = description;
    written["camrig_dataset"] = 1;
    written["picture_suffix"] = picture_suffix;
    if (auto done = write_atomically(folder / description_name, bytes_of_text(written.dump(2) + "\n")); !done)
        return std::unexpected(done.error());
    DatasetWriter writer;
    writer.folder_ = folder;
    writer.picture_suffix_ = picture_suffix;
    return writer;
}

Result<DatasetWriter::Camera*> DatasetWriter::camera(const json& truth, const std::string& frame_rate) {
    const std::string name = truth.at("camera");
    const fs::path folder = folder_ / name;
    for (Camera& known : cameras_)
        if (known.folder == folder) return &known;
    for (const char* part : {"image_2", "label_2", "calib", "gt"})
        if (auto made = make_folders(folder / part); !made) return std::unexpected(made.error());
    const auto ros = ros_calibration(truth);
    if (!ros) return std::unexpected(ros.error());
    if (auto done = write_atomically(folder / "camera_info.yaml", bytes_of_text(*ros)); !done)
        return std::unexpected(done.error());
    if (auto done = write_atomically(folder / "opencv.yml", bytes_of_text(opencv_calibration(truth))); !done)
        return std::unexpected(done.error());
    auto journal = open_to_append(folder / journal_name);
    if (!journal) return std::unexpected(journal.error());
    auto mot = open_to_append(folder / "gt" / "gt.txt");
    if (!mot) return std::unexpected(mot.error());
    const json& size = truth.at("size");
    cameras_.push_back({.folder = folder,
                        .journal = std::move(*journal),
                        .mot = std::move(*mot),
                        .sequence_head = "[Sequence]\nname=" + name + "\nimDir=image_2\nframeRate=" + frame_rate +
                                         "\nimWidth=" + size.at(0).dump() + "\nimHeight=" + size.at(1).dump() +
                                         "\nimExt=" + picture_suffix_ + "\n"});
    return &cameras_.back();
}

Result<void> DatasetWriter::add(const json& truth, std::span<const std::byte> picture, const std::string& frame_rate) {
    auto found = camera(truth, frame_rate);
    if (!found) return std::unexpected(found.error());
    Camera& to = **found;
    const std::int64_t frame = to.frames + 1;
    const std::string name = frame_name(frame);
    if (auto done = write_atomically(to.folder / "image_2" / (name + picture_suffix_), picture); !done) return done;
    const std::string labels = kitti_lines(truth), calibration = kitti_calibration(truth);
    if (auto done = write_atomically(to.folder / "label_2" / (name + ".txt"), bytes_of_text(labels)); !done)
        return done;
    if (auto done = write_atomically(to.folder / "calib" / (name + ".txt"), bytes_of_text(calibration)); !done)
        return done;
    if (auto done = append(to.mot, to.folder / "gt" / "gt.txt", mot_lines(truth, frame)); !done) return done;
    const std::string sequence = sequence_info(to.sequence_head, frame);
    if (auto done = write_atomically(to.folder / "seqinfo.ini", bytes_of_text(sequence)); !done) return done;
    if (auto done = append(to.journal, to.folder / journal_name, truth.dump() + "\n"); !done) return done;
    to.frames = frame;
    return {};
}

Result<std::int64_t> finish_dataset(const fs::path& folder) {
    const auto description = read_description(folder);
    if (!description) return std::unexpected(description.error());
    for (const json& camera : (*description)["cameras"]) {
        const fs::path of_camera = folder / camera.get<std::string>();
        if (!fs::exists(of_camera / journal_name)) continue;
        if (auto done = rewrite_mot(of_camera); !done) return std::unexpected(done.error());
    }
    const fs::path temporary = folder / "coco.json.part";
    const auto frames = write_coco(folder, *description, temporary);
    if (!frames) return frames;
    if (::rename(temporary.c_str(), (folder / "coco.json").c_str()) != 0)
        return std::unexpected(io_error(folder / "coco.json", "written"));
    return frames;
}

}  // namespace camrig
