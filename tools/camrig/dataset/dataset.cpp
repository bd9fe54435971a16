#include "tools/camrig/dataset/dataset.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include "core/base/write_file.h"
#include "core/camera/calibration_file.h"
#include "tools/camrig/dataset/labels.h"

namespace camrig::cli {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr const char* description_name = "dataset.json";
constexpr const char* journal_name = "truth.jsonl";
/// Where a camera has one file a frame.
constexpr std::array frame_folders{"image_2", "label_2", "calib", "labels", "depth", "flow", "instance", "soiling"};

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

Result<std::string> ros_calibration(const json& truth) {
    camera::Calibration calibration;
    calibration.camera_name = truth.at("camera").get<std::string>();
    calibration.size = {truth.at("size").at(0).get<int>(), truth.at("size").at(1).get<int>()};
    const json& k = truth.at("intrinsics");
    calibration.intrinsics = {k.at("fx").get<double>(), k.at("fy").get<double>(), k.at("cx").get<double>(),
                              k.at("cy").get<double>()};
    auto model = parse_name<camera::LensModel>(truth.at("lens").at("model").get<std::string>());
    if (!model) return std::unexpected(model.error());
    calibration.lens.model = *model;
    const json& coefficients = truth.at("lens").at("coefficients");
    for (std::size_t i = 0; i < coefficients.size() && i < calibration.lens.coefficients.size(); ++i)
        calibration.lens.coefficients[i] = coefficients[i].get<double>();
    return write_camera_info(calibration);
}

struct Journal {
    std::int64_t frames = 0;
    std::int64_t bytes = 0;  ///< of its whole lines
};

/// Calls `each(truth, frame)` for every whole line of a journal; a line that was cut off in its middle ends it.
template <typename Each>
Result<Journal> read_journal(const fs::path& file, Each&& each) {
    std::ifstream journal(file, std::ios::binary);
    if (!journal) return error(ErrorKind::not_found, file.string() + ": cannot be read");
    std::string line;
    Journal whole;
    while (std::getline(journal, line) && !journal.eof()) {
        const json truth = json::parse(line, nullptr, false);
        if (truth.is_discarded()) break;
        ++whole.frames;
        whole.bytes += static_cast<std::int64_t>(line.size()) + 1;
        try {
            if (Result<void> done = each(truth, whole.frames); !done) return std::unexpected(done.error());
        } catch (const json::exception& problem) {
            return error(ErrorKind::invalid_argument, file.string() + ": line " + std::to_string(whole.frames) +
                                                          " is no truth that this camrig records: " + problem.what());
        }
    }
    return whole;
}

/// Removes what a recording that broke off has left of frames after the last whole one, temporary files too. Only
/// files that are named as frames are: digits, then a dot.
void remove_loose_files(const fs::path& of_camera, std::int64_t frames) {
    for (const char* part : frame_folders) {
        std::vector<fs::path> loose;
        std::error_code missing;
        for (const auto& entry : fs::directory_iterator(of_camera / part, missing)) {
            const std::string name = entry.path().filename().string();
            const std::size_t digits = name.find_first_not_of("0123456789");
            if (digits == 0 || digits == std::string::npos || digits > 18 || name[digits] != '.') continue;
            const bool is_temporary = name.find('.', digits + 1) != std::string::npos;
            if (is_temporary || std::stoll(name) > frames) loose.push_back(entry.path());
        }
        for (const fs::path& file : loose) fs::remove(file, missing);
    }
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

/// COCO as a stream: the journals are read twice, so that memory does not grow with the recording. Gathers the classes.
Result<std::int64_t> write_coco(const fs::path& folder, const json& description, const fs::path& to, json& classes) {
    std::ofstream out(to, std::ios::binary);
    if (!out) return std::unexpected(io_error(to, "opened"));
    const std::string suffix = description["picture_suffix"];
    std::int64_t frames = 0, annotation_id = 1;
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
                    add_classes(truth.at("classes"), classes);
                    put(coco_image(truth, camera, suffix, image_id, frame));
                } else {
                    for (const json& annotation : coco_annotations(truth, classes, image_id, annotation_id))
                        put(annotation);
                }
                // At once: errno is that of the write which failed.
                if (!out) return std::unexpected(io_error(to, "written"));
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

/// The labels of a camera were written with the classes of its world, or of a set that it was in; those of this set may
/// be others.
Result<void> number_yolo_labels(const fs::path& folder, const json& classes) {
    const auto read = read_journal(folder / journal_name, [&](const json& truth, std::int64_t frame) -> Result<void> {
        const std::string lines = yolo_lines(truth, classes);
        const fs::path file = folder / "labels" / (frame_name(frame) + ".txt");
        std::ifstream labels(file, std::ios::binary);
        std::string there(lines.size() + 1, '\0');
        labels.read(there.data(), std::ssize(there));
        if (labels.gcount() == std::ssize(lines) && there.starts_with(lines)) return {};
        return write_atomically(file, bytes_of_text(lines));
    });
    if (!read) return std::unexpected(read.error());
    return {};
}

std::string sequence_info(const std::string& head, std::int64_t frames) {
    return head + "seqLength=" + std::to_string(frames) + "\n";
}

/// The MOTChallenge files from the journal: a recording that broke off may have labels of a frame that it did not
/// complete. Then nothing is left of such a frame elsewhere either.
Result<void> mend_camera(const fs::path& folder) {
    std::string lines;
    const auto journal =
        read_journal(folder / journal_name, [&](const json& truth, std::int64_t frame) -> Result<void> {
            lines += mot_lines(truth, frame);
            return {};
        });
    if (!journal) return std::unexpected(journal.error());
    if (::truncate((folder / journal_name).c_str(), journal->bytes) != 0)
        return std::unexpected(io_error(folder / journal_name, "cut to its whole lines"));
    remove_loose_files(folder, journal->frames);
    if (auto done = write_atomically(folder / "gt" / "gt.txt", bytes_of_text(lines)); !done) return done;
    std::ifstream info(folder / "seqinfo.ini");
    std::string head;
    for (std::string line; std::getline(info, line);)
        if (!line.starts_with("seqLength=")) head += line + "\n";
    return write_atomically(folder / "seqinfo.ini", bytes_of_text(sequence_info(head, journal->frames)));
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
    writer.with_yolo_ = description.value("yolo", false);
    writer.picture_suffix_ = picture_suffix;
    return writer;
}

Result<DatasetWriter::Camera*> DatasetWriter::camera(const json& truth, const std::string& frame_rate) {
    const std::string name = truth.at("camera");
    const fs::path folder = folder_ / name;
    for (Camera& known : cameras_)
        if (known.folder == folder) return &known;
    if (with_yolo_) {
        // YOLO's trainer finds the labels of .../images/NAME.png at .../labels/NAME.txt. It follows links first, so
        // that `images` must be the folder.
        for (const char* part : {"images", "labels"})
            if (auto made = make_folders(folder / part); !made) return std::unexpected(made.error());
        std::error_code failed;
        fs::create_directory_symlink("images", folder / "image_2", failed);
        if (failed) return error(ErrorKind::unavailable, (folder / "image_2").string() + ": " + failed.message());
    }
    for (const char* part : {"image_2", "label_2", "calib", "gt"})
        if (auto made = make_folders(folder / part); !made) return std::unexpected(made.error());
    const auto ros = ros_calibration(truth);
    if (!ros) return std::unexpected(ros.error());
    if (auto done = write_atomically(folder / "camera_info.yaml", bytes_of_text(*ros)); !done)
        return std::unexpected(done.error());
    if (auto done = write_atomically(folder / "opencv.yml", bytes_of_text(opencv_calibration(truth))); !done)
        return std::unexpected(done.error());
    auto journal = LineFile::open(folder / journal_name);
    if (!journal) return std::unexpected(journal.error());
    auto mot = LineFile::open(folder / "gt" / "gt.txt");
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

Result<DatasetWriter::LineFile> DatasetWriter::LineFile::open(const fs::path& path) {
    LineFile file{.path = path,
                  .fd = UniqueFd(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0666))};
    if (!file.fd) return std::unexpected(io_error(path, "opened"));
    return file;
}

Result<void> DatasetWriter::LineFile::append(const std::string& lines) {
    // A disk that gets full takes a part of the text and says so at the next write only.
    if (auto done = write_all(fd.get(), bytes_of_text(lines), path.string()); !done) {
        cut_back(size);
        return done;
    }
    size += static_cast<std::int64_t>(lines.size());
    return {};
}

void DatasetWriter::LineFile::cut_back(std::int64_t to_size) {
    // Fails on a broken disk only; then finish_dataset() drops the rest.
    if (::ftruncate(fd.get(), to_size) == 0) size = to_size;
}

Result<void> DatasetWriter::add(const json& truth, std::span<const std::byte> picture,
                                const std::vector<FrameFile>& further, const std::string& frame_rate) {
    auto found = camera(truth, frame_rate);
    if (!found) return std::unexpected(found.error());
    Camera& to = **found;
    const std::int64_t frame = to.frames + 1, mot_size = to.mot.size;
    if (auto done = add_files(to, truth, picture, further, frame); !done) {
        to.mot.cut_back(mot_size);
        remove_loose_files(to.folder, to.frames);
        return done;
    }
    to.frames = frame;
    return {};
}

/// The journal's line comes last.
Result<void> DatasetWriter::add_files(Camera& to, const json& truth, std::span<const std::byte> picture,
                                      const std::vector<FrameFile>& further, std::int64_t frame) const {
    const auto put = [&](const std::string& part, const std::string& suffix, std::span<const std::byte> bytes) {
        return write_atomically(to.folder / part / (frame_name(frame) + suffix), bytes);
    };
    if (auto done = put("image_2", picture_suffix_, picture); !done) return done;
    for (const FrameFile& file : further) {
        if (auto made = make_folders(to.folder / file.folder); !made) return made;
        if (auto done = put(file.folder, file.suffix, file.bytes); !done) return done;
    }
    const std::string labels = kitti_lines(truth), calibration = kitti_calibration(truth);
    if (auto done = put("label_2", ".txt", bytes_of_text(labels)); !done) return done;
    if (auto done = put("calib", ".txt", bytes_of_text(calibration)); !done) return done;
    if (with_yolo_)
        if (auto done = put("labels", ".txt", bytes_of_text(yolo_lines(truth, truth.at("classes")))); !done)
            return done;
    if (auto done = to.mot.append(mot_lines(truth, frame)); !done) return done;
    const std::string sequence = sequence_info(to.sequence_head, frame);
    if (auto done = write_atomically(to.folder / "seqinfo.ini", bytes_of_text(sequence)); !done) return done;
    return to.journal.append(truth.dump() + "\n");
}

Result<std::int64_t> finish_dataset(const fs::path& folder) {
    const auto description = read_description(folder);
    if (!description) return std::unexpected(description.error());
    std::vector<std::string> cameras;  // that have frames
    for (const json& camera : (*description)["cameras"]) {
        const auto name = camera.get<std::string>();
        if (!fs::exists(folder / name / journal_name)) continue;
        if (auto done = mend_camera(folder / name); !done) return std::unexpected(done.error());
        cameras.push_back(name);
    }
    const fs::path temporary = folder / "coco.json.part";
    json classes = json::object();
    const auto frames = write_coco(folder, *description, temporary, classes);
    if (!frames) {
        ::unlink(temporary.c_str());
        return frames;
    }
    if (::rename(temporary.c_str(), (folder / "coco.json").c_str()) != 0)
        return std::unexpected(io_error(folder / "coco.json", "written"));
    if (description->value("yolo", false)) {
        for (const std::string& camera : cameras)
            if (auto done = number_yolo_labels(folder / camera, classes); !done) return std::unexpected(done.error());
        const std::string text = yolo_description(cameras, classes);
        if (auto done = write_atomically(folder / "yolo.yaml", bytes_of_text(text)); !done)
            return std::unexpected(done.error());
    }
    return frames;
}

}  // namespace camrig::cli
