#include <numbers>
#include <optional>

#include "control/rpc/methods.h"
#include "core/daylight/sun.h"
#include "core/photo/plate_json.h"
#include "core/photo/shadow_sun.h"

// What `camrig plate` does without a rig, for pages and programs that have one: nothing of the rig is asked or changed.
// Who calls needs the right to command, since a search keeps a processor busy for seconds.
namespace camrig::control {
namespace {

using nlohmann::json;

constexpr double deg = std::numbers::pi / 180.0;
constexpr std::size_t max_projected = 4096;

/// Searches have a thread of their own: the engine's and that of answers have no time for them.
void post_search(RpcContext& context, const RpcReply& done, std::function<Result<RpcResult>()> search) {
    const std::function<void()> job = [done, search = std::move(search)] { done(unless_out_of_memory(search)); };
    if (!context.searches->post(std::function<void()>(job)))
        done(error(ErrorKind::resource_exhausted,
                   std::to_string(max_searches_waiting) + " photos wait already; ask again later"));
}

void calibrate(RpcContext& context, const json& params, const RpcReply& done) {
    JsonReader reader(params, "");
    const auto known = photo::read_known_camera(reader);
    photo::PlateTask task = photo::read_plate_task(reader, known ? std::optional(known->size) : std::nullopt, known);
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    post_search(context, done, [task = std::move(task), known]() -> Result<RpcResult> {
        auto found = photo::calibration_json(task, known);
        if (!found) return std::unexpected(found.error());
        return RpcResult(std::move(*found));
    });
}

/// A list of points or pixels.
template <int count>
std::vector<glm::vec<count, double>> read_places(JsonReader& reader, const char* key) {
    std::vector<glm::vec<count, double>> places;
    // Each is read as a member of an object, which tells what is wrong with it by its place.
    for (const json& each : reader.array(key, max_projected)) {
        const std::string name = std::string(key) + "[" + std::to_string(places.size()) + "]";
        const json holder{{name, each}};
        JsonReader item(holder, "");
        std::array<double, count> numbers{};
        item.required(name, std::span<double>(numbers));
        if (auto good = item.finish(); !good) {
            reader.fail(good.error());
            break;
        }
        auto& place = places.emplace_back();
        for (int i = 0; i < count; ++i) place[i] = numbers[std::size_t(i)];
    }
    return places;
}

/// The camera of a question; none was given, or what is wrong is in the reader.
std::optional<photo::PlateView> read_view(JsonReader& reader) {
    const json* const value = reader.find("camera");
    if (!value) return std::nullopt;
    ImageSize size;
    auto view = photo::read_camera(*value, "camera", &size);
    if (view) return *view;
    reader.fail(view.error());
    return std::nullopt;
}

template <typename Place>
json place_json(const std::optional<Place>& place) {
    json value;
    if (place)
        for (int i = 0; i < Place::length(); ++i) value.push_back((*place)[i]);
    return value;
}

void project(RpcContext& context, const json& params, const RpcReply& done) {
    JsonReader reader(params, "");
    auto view = read_view(reader);
    auto points = read_places<3>(reader, "points");
    auto pixels = read_places<2>(reader, "pixels");
    double z = 0.0;
    reader.optional("z", z);
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    std::function<void()> job = [done, view = *view, points = std::move(points), pixels = std::move(pixels), z] {
        done(unless_out_of_memory([&]() -> Result<RpcResult> {
            json px = json::array(), m = json::array();
            for (const glm::dvec3& each : points) px.push_back(place_json(view.project(each)));
            for (const glm::dvec2& each : pixels) m.push_back(place_json(view.on_ground(each, z)));
            return RpcResult(json{{"px", std::move(px)}, {"m", std::move(m)}});
        }));
    };
    // Milliseconds, as text of answers is: it does not wait for searches.
    if (!context.replies->post(std::move(job))) job();
}

/// What is said of the sun, one way or another.
struct SunQuestion {
    std::optional<std::array<double, 2>> sun{}, place{};
    std::optional<double> time_s{};
    std::optional<photo::Shadow> shadow{};
    std::optional<photo::PlateView> view{};
    double north = 0.5 * std::numbers::pi;
};

SunQuestion read_sun(JsonReader& reader) {
    SunQuestion asked;
    const auto pair = [&](const char* key, std::optional<std::array<double, 2>>& out) {
        if (!reader.find(key)) return;
        out.emplace();
        reader.required(key, std::span<double>(*out));
    };
    pair("sun", asked.sun);
    pair("place", asked.place);
    if (asked.place && (std::abs((*asked.place)[0]) > 90.0 || std::abs((*asked.place)[1]) > 360.0))
        reader.fail("place", "latitude is from -90 to 90, longitude from -360 to 360");
    std::string time;
    reader.optional("time", time);
    if (!time.empty()) {
        const auto instant = daylight::read_instant(time);
        if (instant)
            asked.time_s = *instant;
        else
            reader.fail("time", instant.error().message);
    }
    if (const json* const value = reader.find("shadow")) {
        JsonReader keys(*value, "shadow");
        asked.shadow.emplace();
        const auto pixel = [&](const char* key, glm::dvec2& out) {
            std::array<double, 2> px{};
            keys.required(key, std::span<double>(px));
            out = {px[0], px[1]};
        };
        pixel("top_px", asked.shadow->top_px);
        pixel("foot_px", asked.shadow->foot_px);
        pixel("tip_px", asked.shadow->tip_px);
        keys.optional("z", asked.shadow->z);
        if (auto good = keys.finish(); !good) reader.fail(good.error());
    }
    double north_deg = 90.0;
    reader.optional("north_deg", north_deg);
    asked.north = north_deg * deg;
    asked.view = read_view(reader);
    return asked;
}

/// The way the sun's light travels.
Result<glm::dvec3> direction_of(const SunQuestion& asked, json& found) {
    const auto wrong = [](const char* text) { return error(ErrorKind::invalid_argument, text); };
    const bool by_time = asked.time_s || asked.place;
    if (asked.sun.has_value() + by_time + asked.shadow.has_value() != 1)
        return wrong("sun: give one of sun, time with place, and shadow with camera");
    if (asked.sun)
        return light_direction(daylight::SunPlace{(*asked.sun)[0] * deg, (*asked.sun)[1] * deg}, asked.north);
    if (by_time) {
        if (!asked.time_s) return wrong("time: is missing beside place, as 2026-06-21T14:30:00+02:00");
        if (!asked.place) return wrong("place: is missing beside time, as [latitude, longitude]");
        return light_direction(daylight::sun_at(*asked.time_s, (*asked.place)[0], (*asked.place)[1]), asked.north);
    }
    if (!asked.view) return wrong("camera: is missing; a shadow needs it, as plate.calibrate gives it");
    const auto sun = photo::sun_of_shadow(*asked.view, *asked.shadow);
    if (!sun) return camrig::at("shadow", sun.error());
    found["shadow_of_m"] = sun->height_m;
    found["deviation_deg"] = sun->deviation_rad / deg;
    return sun->light_direction;
}

void light(const json& params, const RpcReply& done) {
    JsonReader reader(params, "");
    const SunQuestion asked = read_sun(reader);
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    json found{{"shadow_of_m", nullptr}, {"deviation_deg", nullptr}};
    const auto direction = direction_of(asked, found);
    if (!direction) return done(std::unexpected(direction.error()));
    const auto matched = photo::match_light(glm::dvec3(1.0), photo::clear_sky, *direction, std::nullopt, 1.0);
    if (!matched) return done(std::unexpected(camrig::at("sun", matched.error()).error()));
    found.update(photo::light_json(*matched, *direction, asked.north));
    done(RpcResult(std::move(found)));
}

std::vector<Field> task_fields() {
    return {{"size", "[width, height]", "of the photo; needed, unless camera_files say it", false, "px"},
            {"camera_files", "object",
             "what another program knows: the text of its file by the file's name (fSpy, OpenCV, ROS), of COLMAP "
             "`cameras.txt` and `images.txt`"},
            {"camera_image", "string", "of several in those files: the image (COLMAP) or camera"},
            {"points", "array of {px, m}", "what is known: a pixel, and its place; without z it is on the ground"},
            {"heights", "array of {foot_px, head_px, height_m, z}",
             "things upright on level ground (at `z`, 0 if not given) of a known height"},
            {"lines", "array of {axis, from_px, to_px}", "edges that run along `x`, `y` or `z` of the world"},
            {"intrinsics", "object", "fx, fy, cx and cy, if known; or vfov_deg"},
            {"vfov_deg", "number", "the field of view, if known; sought if neither is given", false, "deg"},
            {"principal_px", "[u, v]", "of a photo that was cropped", false, "px", "its middle"},
            {"lens", "object", "model and coefficients, if known; see lens"},
            {"fit_k1", "boolean", "seeks k1 of a plumb_bob lens", false, "", "false"},
            {"click_px", "number", "how far a click is off (standard deviation)", false, "px", "from the residuals"},
            {"camera_height_m", "number", "z of the camera, if it was measured", false, "m"}};
}

std::vector<Field> calibration_fields() {
    return {
        {"camera", "object", "size, intrinsics, pose and, unless it is a pinhole, lens: as camera.create takes them"},
        {"verdict", "string",
         "`good`, `fair` or `poor`: whether people are right within 2 or 5 % of their height; `unknown` with the pose "
         "that camera_files have, and then reason, camera and ground are all that is told"},
        {"reason", "string", "the same in a sentence"},
        {"half_95", "object",
         "half widths of 95 % intervals: position, pan_deg, tilt_deg, roll_deg, focal_px, k1; 0 of what is known"},
        {"person_share_95", "number or null",
         "of a person's height, the worst of the places clicked at, or, if none were, of the ground in the lower half "
         "of the photo; null: nobody is seen whole there"},
        {"ground_m_95", "number or null", "of the place of a pixel on the ground, likewise; null: none is seen", false,
         "m"},
        {"ground", "object or null", "`ground` of the backdrop's proxies: what is below the horizon, up to 80 m"},
        {"click_px", "number", "stated, or what the residuals tell", false, "px"},
        {"click_is_stated", "boolean", ""},
        {"degrees_of_freedom", "integer", "clicks beyond those that the camera needs"},
        {"rms_px", "number", "of the residuals", false, "px"},
        {"residuals", "array of {of, px, off_px}",
         "of each click: what it is of (`points[2]`), how far off, and clicked minus calibrated"},
        {"covariance", "object", "of (names of the unknowns), rows, region_95"}};
}

}  // namespace

std::vector<Method> plate_methods(RpcContext& context) {
    using enum ErrorKind;
    return {
        {.name = "plate.calibrate",
         .summary = "Finds from where a photo was taken, and how sure that is: what `camrig plate calibrate` does. "
                    "The photo itself is not needed. docs/backdrops.md explains it.",
         .params = task_fields(),
         .result = calibration_fields(),
         .errors = {invalid_argument, resource_exhausted, unavailable},
         .handler = [&context](const json& params, const RpcReply& done) { calibrate(context, params, done); },
         .example =
             R"({"size": [1280, 720], "click_px": 0.7, "points": [{"px": [315, 710], "m": [6, 2]}, {"px": [964, 710], "m": [6, -2]}, {"px": [1102, 512], "m": [10, -4.5]}, {"px": [188, 421], "m": [14, 6]}, {"px": [518, 259], "m": [9, 1, 2.5]}]})"},
        {.name = "plate.project",
         .summary = "Where a camera shows points of the world, and where its pixels see level ground.",
         .params = {{"camera", "object",
                     "size, intrinsics or vfov_deg, lens and pose, as plate.calibrate and camera.get give them; other "
                     "keys are left alone",
                     true},
                    {"points", "array of [x, y, z]", "at most 4096", false, "m"},
                    {"pixels", "array of [u, v]", "at most 4096", false, "px"},
                    {"z", "number", "height of the ground", false, "m", "0"}},
         .result = {{"px", "array of [u, v] or null", "of each point; null: the lens does not see it", false, "px"},
                    {"m", "array of [x, y, z] or null", "of each pixel; null: over the horizon", false, "m"}},
         .errors = {invalid_argument, resource_exhausted, unavailable},
         .handler = [&context](const json& params, const RpcReply& done) { project(context, params, done); },
         .example =
             R"({"camera": {"size": [640, 480], "vfov_deg": 50, "pose": {"position": [0, 0, 3], "tilt_deg": -20}}, "points": [[8, 1, 0]], "pixels": [[320, 400]]})"},
        {.name = "plate.light",
         .summary = "Sun and sky of a photo, as `lights` and `environment` of a scene: what `camrig plate light` does "
                    "without the photo. Give one of sun, time with place, and shadow with camera.",
         .params = {{"sun", "[azimuth, elevation]", "from north through east, and over the horizon", false, "deg"},
                    {"time", "string", "when it was taken, as `2026-06-21T14:30:00+02:00`"},
                    {"place", "[latitude, longitude]", "where", false, "deg"},
                    {"shadow", "object",
                     "top_px and foot_px of something upright, tip_px of its shadow on the ground (at `z`)"},
                    {"camera", "object", "for shadow; as in plate.project"},
                    {"north_deg", "number", "direction of north in the world, from x counter-clockwise", false, "deg",
                     "90"}},
         .result = {{"azimuth_deg", "number", "of the sun, from north through east", false, "deg"},
                    {"elevation_deg", "number", "over the horizon", false, "deg"},
                    {"lights", "array of objects", "the sun; with the sky level ground in it has 1"},
                    {"environment", "object", "ambient: what a clear sky gives"},
                    {"shadow_of_m", "number or null", "height of what throws the shadow", false, "m"},
                    {"deviation_deg", "number or null", "of the sun's direction, for a click that is a pixel off",
                     false, "deg"}},
         .errors = {invalid_argument},
         .handler = [](const json& params, const RpcReply& done) { light(params, done); },
         .example = R"({"sun": [150, 40]})"},
    };
}

}  // namespace camrig::control
