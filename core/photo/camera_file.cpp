#include "core/photo/camera_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "core/base/json_reader.h"
#include "core/camera/calibration_file.h"
#include "core/camera/lens_map.h"
#include "core/photo/plate_task.h"

namespace camrig::photo {
namespace {

using nlohmann::json;

constexpr std::size_t max_file_bytes = std::size_t{64} << 20;
constexpr const char *colmap_cameras = "cameras.txt", *colmap_images = "images.txt";

Result<std::string> text_of(const std::filesystem::path& path) {
    std::error_code problem;
    const auto bytes = std::filesystem::file_size(path, problem);
    if (problem) return error(ErrorKind::not_found, path.string() + ": " + problem.message());
    if (bytes > max_file_bytes) return invalid(path.string() + ": is larger than 64 MiB");
    std::ifstream file(path, std::ios::binary);
    std::string text(bytes, '\0');
    if (!file.read(text.data(), std::streamsize(bytes)))
        return error(ErrorKind::unavailable, path.string() + ": cannot be read");
    return text;
}

Result<void> check(const KnownCamera& camera) {
    if (std::min(camera.size.width, camera.size.height) < min_photo_side ||
        std::max(camera.size.width, camera.size.height) > max_photo_side)
        return invalid("is of a photo of " + camera.size.to_string() + "; there are photos from 16x16 to 16384x16384");
    if (auto good = camera::check_intrinsics(camera.size, camera.intrinsics); !good) return good;
    if (auto lens = camera::LensMap::create(camera.lens); !lens) return std::unexpected(lens.error());
    return {};
}

/// Lines that are no comments; an empty one stays, which is a photo's list of no points.
std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);)
        if (line.empty() || line[0] != '#') lines.push_back(std::move(line));
    return lines;
}

/// What the numbers of a COLMAP model are: focal lengths (1 or 2), the principal point, then coefficients of this lens
/// at these places (COLMAP 3.11, src/colmap/sensor/models.h).
struct ColmapModel {
    int focals;
    camera::LensModel lens;
    std::vector<std::size_t> places;
};
const std::map<std::string, ColmapModel>& colmap_models() {
    using enum camera::LensModel;
    static const std::map<std::string, ColmapModel> models{
        {"SIMPLE_PINHOLE", {1, pinhole, {}}},
        {"PINHOLE", {2, pinhole, {}}},
        {"SIMPLE_RADIAL", {1, plumb_bob, {0}}},
        {"RADIAL", {1, plumb_bob, {0, 1}}},
        {"OPENCV", {2, plumb_bob, {0, 1, 2, 3}}},
        {"FULL_OPENCV", {2, rational_polynomial, {0, 1, 2, 3, 4, 5, 6, 7}}},
        {"OPENCV_FISHEYE", {2, equidistant, {0, 1, 2, 3}}},
        {"SIMPLE_RADIAL_FISHEYE", {1, equidistant, {0}}},
        {"RADIAL_FISHEYE", {1, equidistant, {0, 1}}}};
    return models;
}

Result<KnownCamera> colmap_camera(const std::string& line) {
    std::istringstream words(line);
    std::string id, name;
    KnownCamera camera;
    words >> id >> name >> camera.size.width >> camera.size.height;
    const auto model = colmap_models().find(name);
    if (!words || model == colmap_models().end())
        return invalid("cameras.txt: camera " + id + ": no model that is known here: " + name);
    const auto& [focals, lens, places] = model->second;
    auto& k = camera.intrinsics;
    words >> k.fx;
    k.fy = k.fx;
    if (focals == 2) words >> k.fy;
    words >> k.cx >> k.cy;
    camera.lens.model = lens;
    for (const std::size_t place : places) words >> camera.lens.coefficients[place];
    if (!words) return invalid("cameras.txt: camera " + id + ": has too few numbers for " + name);
    // COLMAP's pixel centres are at halves.
    k.cx -= 0.5;
    k.cy -= 0.5;
    if (auto good = check(camera); !good) return camrig::at("cameras.txt: camera " + id, good.error());
    return camera;
}

struct ColmapImage {
    std::string camera, name;
    camera::Pose pose;
};

Result<std::optional<ColmapImage>> colmap_image(const std::string& line) {
    std::istringstream words(line);
    std::string id;
    glm::dquat turn;
    glm::dvec3 shift;
    ColmapImage image;
    words >> id >> turn.w >> turn.x >> turn.y >> turn.z >> shift.x >> shift.y >> shift.z >> image.camera >> std::ws;
    std::getline(words, image.name);
    while (!image.name.empty() && (image.name.back() == '\r' || image.name.back() == ' ')) image.name.pop_back();
    if (!words || image.name.empty()) return invalid("images.txt: not a line of an image: " + line.substr(0, 60));
    const double length = glm::length(turn);
    if (!(length > 1e-6)) return invalid("images.txt: image " + image.name + ": its quaternion is zero");
    const glm::dmat3 optical_from_world = glm::mat3_cast(turn / length);
    const glm::dmat3 world_from_link = glm::transpose(optical_from_world) * glm::transpose(camera::link_from_optical());
    auto pose =
        camera::pose_from_quaternion(-(glm::transpose(optical_from_world) * shift), glm::quat_cast(world_from_link));
    if (!pose) return camrig::at("images.txt: image " + image.name, pose.error());
    image.pose = *pose;
    return image;
}

Result<glm::dmat4> read_rows(const json& value, const std::string& path) {
    JsonReader reader(value, path);
    const auto rows = reader.array("rows", 4);
    glm::dmat4 matrix(0.0);
    for (std::size_t row = 0; row < rows.size(); ++row) {
        if (!rows[row].is_array() || rows[row].size() != 4) return invalid(path + ".rows: must be 4 rows of 4 numbers");
        for (std::size_t column = 0; column < 4; ++column) {
            if (!rows[row][column].is_number()) return invalid(path + ".rows: must be 4 rows of 4 numbers");
            matrix[glm::length_t(column)][glm::length_t(row)] = rows[row][column].get<double>();
        }
    }
    if (rows.size() != 4) return invalid(path + ".rows: must be 4 rows of 4 numbers");
    return matrix;
}

}  // namespace

Result<KnownCamera> parse_fspy(const std::string& text) {
    const auto file = parse_json(text, max_file_bytes);
    if (!file) return std::unexpected(file.error());
    // It has more, which nobody needs here.
    json needed = json::object();
    for (const char* key : {"imageWidth", "imageHeight", "horizontalFieldOfView", "principalPoint", "cameraTransform"})
        if (file->is_object() && file->contains(key)) needed[key] = (*file)[key];
    JsonReader reader(needed, "");
    KnownCamera camera;
    double hfov = 0.0;
    reader.required("imageWidth", camera.size.width);
    reader.required("imageHeight", camera.size.height);
    reader.required("horizontalFieldOfView", hfov);
    const json* const middle = reader.find("principalPoint");
    const json* const transform = reader.find("cameraTransform");
    if (!middle || !transform) reader.fail(middle ? "cameraTransform" : "principalPoint", "is missing");
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    JsonReader point(*middle, "principalPoint");
    glm::dvec2 relative;
    point.required("x", relative.x);
    point.required("y", relative.y);
    if (auto done = point.finish(); !done) return std::unexpected(done.error());
    // All of it is of the longer side, also of upright photos: the angle is across it, and the principal point has -1
    // to 1 along it, y up, from the middle.
    const int longer = std::max(camera.size.width, camera.size.height);
    const auto k = camera::intrinsics_from_hfov({longer, longer}, hfov);
    if (!k) return camrig::at("horizontalFieldOfView", k.error());
    camera.intrinsics = *k;
    camera.intrinsics.cx = 0.5 * (camera.size.width - 1 + longer * relative.x);
    camera.intrinsics.cy = 0.5 * (camera.size.height - 1 - longer * relative.y);
    const auto matrix = read_rows(*transform, "cameraTransform");
    if (!matrix) return std::unexpected(matrix.error());
    // Its camera looks along -z, with y up: the optical frame turned about x.
    const glm::dmat3 axes(*matrix);
    const glm::dmat3 turn(axes[0], -axes[1], -axes[2]);
    if (std::abs(glm::determinant(turn) - 1.0) > 1e-3) return invalid("cameraTransform: is no rotation and a place");
    const auto pose = camera::pose_from_quaternion(glm::dvec3((*matrix)[3]),
                                                   glm::quat_cast(turn * glm::transpose(camera::link_from_optical())));
    if (!pose) return camrig::at("cameraTransform", pose.error());
    camera.pose = *pose;
    if (auto good = check(camera); !good) return std::unexpected(good.error());
    return camera;
}

Result<KnownCamera> parse_colmap(const std::string& cameras, const std::string& images, const std::string& image) {
    std::vector<ColmapImage> found;
    const auto lines = lines_of(images);
    std::string names;
    // Every second line is the points of the image before it.
    for (std::size_t n = 0; n < lines.size(); n += 2) {
        if (lines[n].empty()) break;
        auto each = colmap_image(lines[n]);
        if (!each) return std::unexpected(each.error());
        if (names.size() < 200) names += (names.empty() ? "" : ", ") + (*each)->name;
        if (image.empty() || (*each)->name == image) found.push_back(std::move(**each));
    }
    if (!images.empty() && found.size() != 1)
        return error(ErrorKind::not_found,
                     "images.txt: " + (image.empty() ? "name the image" : "no image " + image) + "; it has " + names);
    if (images.empty() && !image.empty())
        return invalid("cameras.txt: image " + image + " is named in images.txt; give that too");
    std::vector<std::string> known = lines_of(cameras);
    std::erase_if(known, [](const std::string& line) { return line.find_first_not_of(" \t\r") == line.npos; });
    if (images.empty() && known.size() > 1)
        return invalid("cameras.txt: has " + std::to_string(known.size()) +
                       " cameras; give images.txt too, and name the image");
    for (const std::string& line : known) {
        const std::string id = line.substr(0, line.find(' '));
        if (!found.empty() && id != found[0].camera) continue;
        auto camera = colmap_camera(line);
        if (camera && !found.empty()) camera->pose = found[0].pose;
        return camera;
    }
    return error(ErrorKind::not_found, "cameras.txt: has no camera" + (found.empty() ? "" : " " + found[0].camera));
}

Result<KnownCamera> parse_camera_files(const std::map<std::string, std::string>& texts, const std::string& image,
                                       std::optional<ImageSize> size) {
    if (texts.empty()) return invalid("no file is given");
    const auto cameras = texts.find(colmap_cameras), images = texts.find(colmap_images);
    const bool is_colmap = cameras != texts.end() || images != texts.end();
    if (is_colmap && cameras == texts.end())
        return error(ErrorKind::not_found, std::string(colmap_images) + ": belongs to a cameras.txt; give that too");
    if (texts.size() > (is_colmap && images != texts.end() ? 2u : 1u))
        return invalid(texts.rbegin()->first + ": one file too many; give one, or cameras.txt with images.txt");
    const auto& [name, text] = is_colmap ? *cameras : *texts.begin();
    Result<KnownCamera> camera = invalid("");
    if (is_colmap) {
        camera = parse_colmap(text, images == texts.end() ? "" : images->second, image);
        if (!camera) return camera;
    } else if (text.contains("\"cameraTransform\"")) {
        camera = parse_fspy(text);
        if (!camera) return camrig::at(name, camera.error());
    } else {
        const auto read = camera::parse_calibration(text, name, {.camera = image, .size = size});
        if (!read) return std::unexpected(read.error());
        camera = KnownCamera{read->size, read->intrinsics, read->lens, std::nullopt};
    }
    if (size && (camera->size.width != size->width || camera->size.height != size->height))
        return invalid(
            name + ": is of a photo of " + camera->size.to_string() + ", and this one is " + size->to_string() +
            (camera->size.width == size->height ? "; was it turned?"
                                                : "; calibrate the photo as it is, neither cropped nor scaled"));
    return camera;
}

Result<KnownCamera> read_camera_file(const std::filesystem::path& file, const std::string& image,
                                     std::optional<ImageSize> size) {
    std::error_code problem;
    const bool is_folder = std::filesystem::is_directory(file, problem);
    const std::string name = file.filename().string();
    if (!is_folder && name != colmap_cameras && name != colmap_images) {
        const auto text = text_of(file);
        if (!text) return std::unexpected(text.error());
        return parse_camera_files({{file.string(), *text}}, image, size);
    }
    const std::filesystem::path folder = is_folder ? file : file.parent_path();
    std::map<std::string, std::string> texts;
    for (const char* const part : {colmap_cameras, colmap_images}) {
        if (part == colmap_images && !std::filesystem::exists(folder / part, problem)) continue;
        auto text = text_of(folder / part);
        if (!text) return std::unexpected(text.error());
        texts.emplace(part, std::move(*text));
    }
    auto camera = parse_camera_files(texts, image, size);
    if (!camera) return camrig::at(folder.string(), camera.error());
    return camera;
}

}  // namespace camrig::photo
