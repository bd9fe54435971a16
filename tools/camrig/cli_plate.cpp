#include "tools/camrig/cli_plate.h"

#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>

#include <CLI/CLI.hpp>

#include "core/photo/plate_json.h"
#include "core/world/backdrop/backdrop.h"
#include "tools/camrig/cli_commands.h"
#include "tools/camrig/photo_file.h"
#include "tools/camrig/scene_edit.h"

namespace camrig::cli {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::size_t max_clicks_bytes = std::size_t{1} << 20;

struct CalibrateOptions {
    fs::path clicks, photo, known, output, scene;
    std::string size, image, name = "plate";
    std::vector<std::string> points, heights, lines;
    std::optional<double> vfov_deg, click_px, camera_height_m;
    bool fit_k1 = false;
};

/// "A,B:C,D=E,F" -> three lists of numbers, each as long as asked for (0: of any length).
Result<json> parse_click(const char* option, const std::string& text, std::size_t pixels) {
    const std::size_t equals = text.find('=');
    json parts = json::array();
    std::string left = text.substr(0, equals);
    for (std::size_t n = 0; n < pixels; ++n) {
        const std::size_t colon = n + 1 < pixels ? left.find(':') : std::string::npos;
        auto px = parse_numbers(option, left.substr(0, colon), 2);
        if (!px) return px;
        parts.push_back(*px);
        left = colon == std::string::npos ? "" : left.substr(colon + 1);
    }
    parts.push_back(equals == std::string::npos ? "" : text.substr(equals + 1));
    return parts;
}

/// What was typed, put to what the file of clicks says.
Result<json> clicks_of(const CalibrateOptions& options) {
    json all = json::object();
    if (!options.clicks.empty()) {
        std::ifstream file(options.clicks, std::ios::binary);
        std::ostringstream text;
        if (!(text << file.rdbuf())) return error(ErrorKind::not_found, options.clicks.string() + ": cannot be read");
        auto read = parse_json(text.str(), max_clicks_bytes);
        if (!read) return at(options.clicks.string(), read.error());
        all = std::move(*read);
        if (!all.is_object())
            return error(ErrorKind::invalid_argument, options.clicks.string() + ": expected an object");
        for (const char* list : {"points", "heights", "lines"})
            if (all.contains(list) && !all[list].is_array())
                return error(ErrorKind::invalid_argument, options.clicks.string() + ": " + list + ": expected a list");
    }
    for (const std::string& each : options.points) {
        auto parts = parse_click("--point", each, 1);
        if (!parts) return parts;
        const std::string metres = (*parts)[1];
        auto m = parse_numbers("--point, U,V=X,Y,Z", metres, metres.find(',') == metres.rfind(',') ? 2 : 3);
        if (!m) return m;
        all["points"].push_back({{"px", (*parts)[0]}, {"m", *m}});
    }
    for (const std::string& each : options.heights) {
        auto parts = parse_click("--height, FOOT:HEAD=METRES", each, 2);
        if (!parts) return parts;
        auto m = parse_numbers("--height, FOOT:HEAD=METRES", (*parts)[2].get<std::string>(), 1);
        if (!m) return m;
        all["heights"].push_back({{"foot_px", (*parts)[0]}, {"head_px", (*parts)[1]}, {"height_m", (*m)[0]}});
    }
    for (const std::string& each : options.lines) {
        auto parts = parse_click("--line, FROM:TO=AXIS", each, 2);
        if (!parts) return parts;
        all["lines"].push_back({{"axis", (*parts)[2]}, {"from_px", (*parts)[0]}, {"to_px", (*parts)[1]}});
    }
    if (options.vfov_deg) all["vfov_deg"] = *options.vfov_deg;
    if (options.click_px) all["click_px"] = *options.click_px;
    if (options.camera_height_m) all["camera_height_m"] = *options.camera_height_m;
    if (options.fit_k1) all["fit_k1"] = true;
    return all;
}

/// Puts what was found into a camera's entry, whose size may be another one.
void put_camera(OrderedJson& entry, const json& found, const photo::PlateView& view, ImageSize size,
                const CalibrateOptions& options) {
    for (const char* key : {"vfov_deg", "hfov_deg", "intrinsics", "lens"}) entry.erase(key);
    if (entry.contains("backdrop") && entry["backdrop"].is_null()) entry.erase("backdrop");
    if (entry.contains("backdrop")) entry["backdrop"].erase("intrinsics");
    for (const auto& [key, value] : found.items())
        if (key != "size" || !entry.contains("size")) entry[key] = value;
    const bool is_scaled = entry["size"] != OrderedJson(found["size"]);
    if (!options.photo.empty() && !entry.contains("backdrop")) {
        const fs::path folder = fs::absolute(options.scene.empty() ? options.output : options.scene).parent_path();
        OrderedJson backdrop{{"file", fs::proximate(fs::absolute(options.photo), folder).string()}};
        if (const json ground = photo::ground_json(view, size); !ground.is_null())
            backdrop["proxies"]["ground"] = ground;
        entry["backdrop"] = std::move(backdrop);
    }
    if (is_scaled && entry.contains("backdrop")) {
        entry["backdrop"]["intrinsics"] = found["intrinsics"];
        entry.erase("intrinsics");
    }
}

Result<void> write_found(const json& found, const photo::PlateView& view, ImageSize size,
                         const CalibrateOptions& options) {
    if (!options.output.empty()) {
        OrderedJson entry{{"name", options.name}};
        put_camera(entry, found, view, size, options);
        if (auto done = write_json_text(options.output, entry); !done) return done;
    }
    if (options.scene.empty()) return {};
    auto scene = read_scene_text(options.scene);
    if (!scene) return std::unexpected(scene.error());
    const auto entry = camera_of(*scene, options.name, true);
    if (!entry) return at(options.scene.string(), entry.error());
    put_camera(**entry, found, view, size, options);
    return write_json_text(options.scene, *scene);
}

std::string text_of(const json& result) {
    const json& camera = result["camera"];
    const json& half = result.value("half_95", json::object());
    const auto pair = [&](const json& value, const char* key) {
        return plain_text(value) + (half.contains(key) ? " +- " + plain_text(half[key]) : "");
    };
    std::string text = result["reason"].get<std::string>() + "\n";
    const json& position = camera["pose"]["position"];
    for (int n = 0; n < 3; ++n) {
        text += std::string(n ? ", " : "camera at ") + "xyz"[n] + " " + plain_text(position[std::size_t(n)]);
        if (half.contains("position")) text += " +- " + plain_text(half["position"][std::size_t(n)]);
    }
    text += " m; pan " + pair(camera["pose"]["pan_deg"], "pan_deg") + ", tilt " +
            pair(camera["pose"]["tilt_deg"], "tilt_deg") + ", roll " + pair(camera["pose"]["roll_deg"], "roll_deg") +
            " deg; focal length " + pair(camera["intrinsics"]["fx"], "focal_px") + " px";
    if (!result.contains("residuals")) return text;
    std::vector<std::vector<std::string>> rows{{"click", "off (px)", "x", "y"}};
    for (const json& each : result["residuals"])
        rows.push_back(
            {each["of"], plain_text(each["px"]), plain_text(each["off_px"][0]), plain_text(each["off_px"][1])});
    return text + "\n" + table(rows);
}

int calibrate(const CliContext& context, const CalibrateOptions& options) {
    std::optional<ImageSize> size;
    if (!options.photo.empty()) {
        const auto picture = read_photo(options.photo);
        if (!picture) return context.fail(picture.error());
        size = picture->size;
    } else if (!options.size.empty()) {
        const auto sides = parse_size(options.size);
        if (!sides) return context.fail(sides.error());
        size = ImageSize{(*sides)[0].get<int>(), (*sides)[1].get<int>()};
    }
    std::optional<photo::KnownCamera> known;
    if (!options.known.empty()) {
        auto read = photo::read_camera_file(options.known, options.image, size);
        if (!read) return context.fail(read.error());
        known = *read;
        size = known->size;
    }
    const auto clicks = clicks_of(options);
    if (!clicks) return context.fail(clicks.error());
    JsonReader reader(*clicks, "");
    const photo::PlateTask task = photo::read_plate_task(reader, size, known);
    if (auto done = reader.finish(); !done)
        return context.fail(options.clicks.empty() ? done.error() : at(options.clicks.string(), done.error()).error());
    const auto result = photo::calibration_json(task, known);
    if (!result) return context.fail(result.error());
    const json& camera = (*result)["camera"];
    ImageSize view_size;
    const auto view = photo::read_camera(camera, "camera", &view_size);
    if (!view) return context.fail(view.error());
    if (auto done = write_found(camera, *view, view_size, options); !done) return context.fail(done.error());
    return context.print(*result, text_of(*result));
}

}  // namespace

void add_plate_calibrate(CLI::App& plate, CliContext& context) {
    auto options = std::make_shared<CalibrateOptions>();
    CLI::App* command = plate.add_subcommand(
        "calibrate",
        "finds from where a photo was taken: from clicked points, known heights and lines, or another program's file");
    command->add_option("CLICKS", options->clicks,
                        "JSON file with points, heights, lines, vfov_deg, ... (docs/backdrops.md)");
    command->add_option("--photo", options->photo, "the photo: PNG or JPEG");
    command->add_option("--size", options->size, "WIDTHxHEIGHT of the photo, without --photo");
    command->add_option("--point", options->points, "U,V=X,Y,Z: pixel and metres; without Z on the ground")
        ->allow_extra_args(false);
    command
        ->add_option("--height", options->heights, "U,V:U,V=METRES: foot and head of something upright on the ground")
        ->allow_extra_args(false);
    command->add_option("--line", options->lines, "U,V:U,V=AXIS: two places on an edge along x, y or z")
        ->allow_extra_args(false);
    command->add_option("--camera", options->known,
                        "what another program knows: fSpy JSON, COLMAP folder, OpenCV or ROS YAML");
    command->add_option("--image", options->image, "of several in that file: the image (COLMAP) or camera");
    command->add_option("--vfov-deg", options->vfov_deg, "known field of view; sought if not given");
    command->add_option("--click-px", options->click_px, "error of a click; from the residuals if not given");
    command->add_option("--camera-height", options->camera_height_m,
                        "metres of the camera over the ground; sought if not given");
    command->add_flag("--fit-k1", options->fit_k1, "seeks k1 of the lens too");
    command->add_option("--name", options->name, "of the camera; default plate");
    command->add_option("-o,--output", options->output,
                        "writes the camera as JSON, as scene files and `camera create --file` take it");
    command->add_option("--scene", options->scene,
                        "puts the camera into this scene file, in the place of one of its name");
    command->callback(
        [options, &context] { context.action = [options, &context] { return calibrate(context, *options); }; });
}

void add_plate_commands(CLI::App& app, CliContext& context) {
    CLI::App* command = app.add_subcommand("plate", "the camera and the light of a photo that people shall walk in");
    command->require_subcommand(1);
    add_plate_calibrate(*command, context);
    add_plate_light(*command, context);
}

}  // namespace camrig::cli
