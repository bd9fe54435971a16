#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <set>

#include <CLI/CLI.hpp>

#include "core/daylight/sun.h"
#include "core/photo/plate_json.h"
#include "core/photo/plate_light.h"
#include "core/photo/shadow_sun.h"
#include "core/world/daylit.h"
#include "core/world/scene_base.h"
#include "tools/camrig/cli_plate.h"
#include "tools/camrig/photo_file.h"
#include "tools/camrig/scene_edit.h"

namespace camrig::cli {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr double deg = std::numbers::pi / 180.0;

struct LightOptions {
    fs::path photo, camera, scene, output;
    std::string name = "plate", sun, time, place, shadow, lit, shaded, white, edge;
    double north_deg = 90.0, reflectance = 0.9;
    bool noise = false;
};

Result<json> numbers_of(const char* option, const std::string& text, std::size_t count) {
    return parse_numbers(option, text, count);
}

/// The calibrated camera, of its own file or of the scene, in the photo's own pixels.
Result<photo::PlateView> view_of(const LightOptions& options) {
    const fs::path& file = options.camera.empty() ? options.scene : options.camera;
    if (file.empty()) return error(ErrorKind::invalid_argument, "--shadow: needs the camera; give --camera or --scene");
    auto text = read_scene_text(file);
    if (!text) return std::unexpected(text.error());
    OrderedJson entry = *text;
    if (options.camera.empty()) {
        const auto found = camera_of(*text, options.name, false);
        if (!found) return at(file.string(), found.error());
        entry = **found;
    }
    if (entry.contains("backdrop") && entry["backdrop"].contains("intrinsics"))
        entry["intrinsics"] = entry["backdrop"]["intrinsics"];
    ImageSize size;
    return photo::read_camera(json::parse(entry.dump()), file.string() + ": camera " + options.name, &size);
}

/// The way the sun's light travels; none was asked for: no value.
Result<std::optional<glm::dvec3>> direction_of(const LightOptions& options, json& found) {
    if (!options.sun.empty() + (!options.time.empty() || !options.place.empty()) + !options.shadow.empty() > 1)
        return error(ErrorKind::invalid_argument, "give one of --sun, --time with --place, and --shadow");
    const double north = options.north_deg * deg;
    if (!options.sun.empty()) {
        const auto angles = numbers_of("--sun AZIMUTH,ELEVATION", options.sun, 2);
        if (!angles) return std::unexpected(angles.error());
        return light_direction(daylight::SunPlace{(*angles)[0].get<double>() * deg, (*angles)[1].get<double>() * deg},
                               north);
    }
    if (!options.time.empty() || !options.place.empty()) {
        const auto place = numbers_of("--place LATITUDE,LONGITUDE", options.place, 2);
        if (!place) return std::unexpected(place.error());
        const double latitude = (*place)[0], longitude = (*place)[1];
        if (std::abs(latitude) > 90.0 || std::abs(longitude) > 360.0)
            return error(ErrorKind::invalid_argument,
                         "--place: latitude is from -90 to 90, longitude from -360 to 360");
        const auto at = daylight::read_instant(options.time);
        if (!at) return camrig::at("--time", at.error());
        return light_direction(daylight::sun_at(*at, latitude, longitude), north);
    }
    if (options.shadow.empty()) return std::nullopt;
    std::array<glm::dvec2, 3> px;
    std::string rest = options.shadow;
    for (std::size_t n = 0; n < 3; ++n) {
        const std::size_t colon = n < 2 ? rest.find(':') : std::string::npos;
        const auto each = numbers_of("--shadow TOP:FOOT:TIP, each U,V", rest.substr(0, colon), 2);
        if (!each) return std::unexpected(each.error());
        px[n] = {(*each)[0].get<double>(), (*each)[1].get<double>()};
        rest = colon == std::string::npos ? "" : rest.substr(colon + 1);
    }
    const auto view = view_of(options);
    if (!view) return std::unexpected(view.error());
    const auto sun = photo::sun_of_shadow(*view, {px[0], px[1], px[2], 0.0});
    if (!sun) return camrig::at("--shadow", sun.error());
    found["shadow_of_m"] = sun->height_m;
    found["deviation_deg"] = sun->deviation_rad / deg;
    return sun->light_direction;
}

json color_json(const glm::dvec3& c) {
    return {c.r, c.g, c.b};
}

Result<glm::dvec3> light_at(const photo::Picture& picture, const char* option, const std::string& text) {
    const auto sides = numbers_of(option, text, 4);
    if (!sides) return std::unexpected(sides.error());
    const auto whole = [&](std::size_t n) { return int(std::clamp((*sides)[n].get<double>(), -1e6, 1e6)); };
    auto light = photo::mean_light(picture, {whole(0), whole(1), whole(2), whole(3)});
    if (!light) return camrig::at(option, light.error());
    return light;
}

/// Sun and sky, from what was measured or, without that, an ordinary clear sky.
Result<photo::PlateLight> match(const LightOptions& options, const std::optional<photo::Picture>& picture,
                                const glm::dvec3& direction, json& found) {
    std::optional<glm::dvec3> white;
    const auto measured = [&](const char* option, const std::string& text) -> Result<glm::dvec3> {
        if (!picture) return error(ErrorKind::invalid_argument, std::string(option) + ": needs the PHOTO");
        return light_at(*picture, option, text);
    };
    if (!options.white.empty()) {
        const auto light = measured("--white", options.white);
        if (!light) return std::unexpected(light.error());
        white = *light;
    }
    if (options.lit.empty() != options.shaded.empty())
        return error(ErrorKind::invalid_argument, "--lit and --shaded: give both, of the same level surface");
    glm::dvec3 lit(1.0), shaded = photo::clear_sky;
    found["sky_is_measured"] = !options.lit.empty();
    if (!options.lit.empty()) {
        const auto one = measured("--lit", options.lit);
        if (!one) return std::unexpected(one.error());
        const auto other = measured("--shaded", options.shaded);
        if (!other) return std::unexpected(other.error());
        lit = *one;
        shaded = *other;
    }
    return photo::match_light(lit, shaded, direction, white, options.reflectance);
}

Result<void> put_light(const LightOptions& options, const std::optional<photo::Picture>& picture, json& found) {
    const auto direction = direction_of(options, found);
    if (!direction) return std::unexpected(direction.error());
    if (!*direction) {
        if (!options.lit.empty() || !options.white.empty())
            return error(ErrorKind::invalid_argument,
                         "--lit, --shaded, --white: need the sun; give --sun, --time and --place, or --shadow");
        return {};
    }
    const auto light = match(options, picture, **direction, found);
    if (!light) return std::unexpected(light.error());
    found.update(photo::light_json(*light, **direction, options.north_deg * deg));
    if (!options.white.empty()) found["backdrop"]["plate_gain"] = color_json(light->gain);
    return {};
}

Result<void> put_picture(const LightOptions& options, const std::optional<photo::Picture>& picture, json& found) {
    if ((options.noise || !options.edge.empty()) && !picture)
        return error(ErrorKind::invalid_argument, "--noise, --edge: need the PHOTO");
    if (options.noise) {
        const auto noise = photo::fit_noise(*picture);
        if (!noise) return std::unexpected(noise.error());
        found["backdrop"]["noise"] = {{"k", noise->k}, {"read", noise->read}};
    }
    if (options.edge.empty()) return {};
    const auto sides = numbers_of("--edge", options.edge, 4);
    if (!sides) return std::unexpected(sides.error());
    const auto whole = [&](std::size_t n) { return int(std::clamp((*sides)[n].get<double>(), -1e6, 1e6)); };
    const auto edge = photo::fit_edge(*picture, {whole(0), whole(1), whole(2), whole(3)});
    if (!edge) return at("--edge", edge.error());
    found["backdrop"]["edge_px"] = *edge;
    return {};
}

/// The scene that a scene stands on, whole; an empty object where it stands on none.
Result<json> base_of(const OrderedJson& scene, const fs::path& file) {
    if (!scene.contains("base")) return json::object();
    auto based = world::on_its_base({{"base", json::parse(scene["base"].dump())}}, file);
    if (!based) return at(file.string(), based.error());
    return std::move(based->document);
}

/// The scene's own lights with this sun as the only one. A base's lights cannot be taken away: its suns are put out.
OrderedJson lights_with(OrderedJson sun, const OrderedJson& scene, const json& base) {
    OrderedJson lights = OrderedJson::array(), put_out = OrderedJson::array();
    const auto name_of_sun = sun.at("name").get<std::string>();
    std::set<std::string> suns;
    for (const json& light : base.value("lights", json::array())) {
        if (light.value("type", "") != "directional") continue;
        const std::string name = light.value("name", "");
        suns.insert(name);
        OrderedJson& over =
            name == name_of_sun ? sun : put_out.emplace_back(OrderedJson{{"name", name}, {"intensity", 0}});
        if (light.contains("lux")) over["lux"] = nullptr;
    }
    for (const OrderedJson& light : scene.value("lights", OrderedJson::array()))
        if (light.value("type", "") != "directional" && !suns.contains(light.value("name", "")))
            lights.push_back(light);
    lights.insert(lights.end(), put_out.begin(), put_out.end());
    lights.push_back(std::move(sun));
    return lights;
}

/// Into the scene: its sun is replaced, other lights stay.
Result<void> write_scene(const LightOptions& options, const json& found) {
    auto scene = read_scene_text(options.scene);
    if (!scene) return std::unexpected(scene.error());
    if (found.contains("lights")) {
        const auto base = base_of(*scene, options.scene);
        if (!base) return std::unexpected(base.error());
        (*scene)["lights"] = lights_with(OrderedJson(found["lights"][0]), *scene, *base);
        OrderedJson& environment = (*scene)["environment"];
        environment["ambient"] = found["environment"]["ambient"];
        // Daylight makes sun and ambient itself; lamps in candela count by its lux.
        const json below = base->value("environment", json::object());
        const bool has_daylight =
            environment.contains("daylight") ? !environment["daylight"].is_null() : below.contains("daylight");
        environment.erase("daylight");
        if (below.contains("daylight")) environment["daylight"] = nullptr;
        if (has_daylight && !environment.contains("lux") && !below.contains("lux"))
            environment["lux"] = world::daylight_lux;
    }
    if (found.contains("backdrop")) {
        const auto camera = camera_of(*scene, options.name, false);
        if (!camera) return at(options.scene.string(), camera.error());
        for (const auto& [key, value] : found["backdrop"].items()) (**camera)["backdrop"][key] = value;
    }
    return write_json_text(options.scene, *scene);
}

int light(const CliContext& context, const LightOptions& options) {
    std::optional<world::Image> image;
    std::optional<photo::Picture> picture;
    if (!options.photo.empty()) {
        auto read = read_photo(options.photo);
        if (!read) return context.fail(read.error());
        image = std::move(*read);
        picture = photo::Picture{image->size, image->rgba};
    }
    json found = json::object();
    if (auto done = put_light(options, picture, found); !done) return context.fail(done.error());
    if (auto done = put_picture(options, picture, found); !done) return context.fail(done.error());
    if (found.empty())
        return context.fail({ErrorKind::invalid_argument,
                             "nothing is asked for; give --sun, --time and --place, --shadow, --noise or --edge"});
    if (!options.output.empty())
        if (auto done = write_json_text(options.output, OrderedJson(found)); !done) return context.fail(done.error());
    if (!options.scene.empty())
        if (auto done = write_scene(options, found); !done) return context.fail(done.error());
    return context.print(found, found.dump(2));
}

}  // namespace

void add_plate_light(CLI::App& plate, CliContext& context) {
    auto options = std::make_shared<LightOptions>();
    CLI::App* command = plate.add_subcommand(
        "light", "finds the light of a photo, as lights and environment of a scene, and its noise and softness");
    command->add_option("PHOTO", options->photo, "PNG or JPEG; for all that is measured in it");
    command->add_option("--sun", options->sun,
                        "AZIMUTH,ELEVATION in degrees, from north through east and over the horizon");
    command->add_option("--time", options->time, "when it was taken, as 2026-06-21T14:30:00+02:00");
    command->add_option("--place", options->place, "LATITUDE,LONGITUDE in degrees, north and east positive");
    command->add_option("--north-deg", options->north_deg,
                        "direction of north in the world, from x counter-clockwise; default 90: y");
    command->add_option("--shadow", options->shadow,
                        "U,V:U,V:U,V: top and foot of something upright and the tip of its shadow on the ground");
    command->add_option("--lit", options->lit, "X,Y,WIDTH,HEIGHT: level ground in the sun");
    command->add_option("--shaded", options->shaded, "X,Y,WIDTH,HEIGHT: the same ground in full shadow");
    command->add_option("--white", options->white,
                        "X,Y,WIDTH,HEIGHT: something white or grey that lies in the sun; gives plate_gain");
    command->add_option("--reflectance", options->reflectance, "of it; default 0.9, white paper");
    command->add_flag("--noise", options->noise, "fits the noise of the photo");
    command->add_option("--edge", options->edge, "X,Y,WIDTH,HEIGHT: one sharp straight edge; gives edge_px");
    command->add_option("--camera", options->camera,
                        "the calibrated camera, as `plate calibrate -o` writes it; for --shadow");
    command->add_option("--scene", options->scene, "scene file: has the camera, and gets the sun and the sky");
    command->add_option("--name", options->name, "of the camera in the scene; default plate");
    command->add_option("-o,--output", options->output, "writes all that was found as JSON");
    command->callback(
        [options, &context] { context.action = [options, &context] { return light(context, *options); }; });
}

}  // namespace camrig::cli
