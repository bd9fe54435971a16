#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <tuple>

#include <CLI/CLI.hpp>

#include "control/client/camera_file.h"
#include "core/world/camera_fields.h"
#include "core/world/camera_json.h"
#include "tools/camrig/cli_calibration.h"
#include "tools/camrig/cli_camera_options.h"
#include "tools/camrig/cli_commands.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

std::string size_text(const json& camera) {
    return plain_text(camera.at("size").at(0)) + "x" + plain_text(camera.at("size").at(1));
}

std::string short_text(const json& camera) {
    return camera.at("name").get<std::string>() + ": " + size_text(camera) + " at " + plain_text(camera.at("fps")) +
           " frames/s, shown from world time " + seconds_text(camera.at("applied_ns"));
}

std::string vector_text(const json& numbers) {
    std::string text;
    for (const json& number : numbers) text += (text.empty() ? "" : ",") + plain_text(number);
    return text;
}

/// A value with its unit, for people.
std::string value_text(const Field& field, const json& value) {
    if (value.is_null()) return field.null;
    if (value.is_boolean()) return value == true ? "yes" : "no";
    if (field.type == "[width, height]") return size_text({{"size", value}}) + " " + field.unit;
    return (value.is_array() ? vector_text(value) : plain_text(value)) + (field.unit.empty() ? "" : " " + field.unit);
}

/// A row for each value, those of objects below the name of the object.
void add_rows(std::vector<std::vector<std::string>>& rows, const std::vector<Field>& fields, const json& values,
              const std::string& within) {
    for (const Field& field : fields) {
        const auto found = values.find(field.name);
        if (found == values.end()) continue;
        const std::string label = within + field.label_text();
        if (found->is_object())
            add_rows(rows, field.parts, *found, label + " ");
        else if (field.type != "array of objects")
            rows.push_back({label, value_text(field, *found)});
        else
            for (const json& item : *found) rows.push_back({label, item.dump()});
    }
}

std::string long_text(const json& camera) {
    // What is not there throws: a rig of another version is told from this one, and nothing is made up.
    const json expected = world::camera_to_json({});
    for (const auto& [name, value] : expected.items()) std::ignore = camera.at(name);
    std::vector<std::vector<std::string>> rows;
    add_rows(rows, descriptions_of(world::camera_fields()), camera, "");
    return table(rows, 2);
}

/// camera.create; with `replaces`, a camera that is there is changed into this one.
Result<json> create_or_set(client::RpcClient& client, const json& camera, bool replaces) {
    auto made = client.call("camera.create", camera);
    if (made || !replaces || made.error().kind != ErrorKind::already_exists) return made;
    auto set = client.call("camera.set", camera);
    // Not the name is taken, but what the camera wants: a device's number, a port.
    return !set && set.error().kind == ErrorKind::not_found ? made : set;
}

/// `name`, if given, is for the only camera of the file.
int create_from_file(const CliContext& context, const std::filesystem::path& file, const std::string& name,
                     bool replaces) {
    auto cameras = client::read_camera_file(file);
    if (!cameras) return context.fail(cameras.error());
    if (!name.empty()) {
        if (cameras->size() != 1 || !(*cameras)[0].is_object())
            return context.usage("camera create: NAME with --file needs a file of one camera");
        (*cameras)[0]["name"] = name;
    }
    auto client = context.connect();
    if (!client) return context.fail(client.error());
    json created = json::array();
    std::string words;
    for (std::size_t i = 0; i < cameras->size(); ++i) {
        auto camera = create_or_set(*client, (*cameras)[i], replaces);
        if (!camera) {
            Error why = camera.error();
            why.message.insert(0, client::camera_in_file(file, i));
            return context.fail(why);
        }
        words += short_text(*camera) + "\n";
        created.push_back(std::move(*camera));
    }
    return context.print({{"cameras", std::move(created)}}, words);
}

void add_create(CLI::App& camera, CliContext& context) {
    struct Options {
        std::string name, place;
        std::filesystem::path file;
        bool replaces = false;
        CameraOptions camera;
    };
    auto options = std::make_shared<Options>();
    CLI::App* create = camera.add_subcommand("create", "makes a camera, or those of a file");
    auto* name =
        create->add_option("NAME", options->name, "1 to 24 of a-z, 0-9 and _; with --file: instead of its name");
    create->add_option("--place", options->place, "a named place of the scene: pose and field of view");
    auto* file = create->add_option("--file", options->file,
                                    "JSON: a camera (as `camera get --json` prints it), a list of them, "
                                    "or {\"cameras\": [...]}");
    auto* replace = create
                        ->add_flag("--replace", options->replaces,
                                   "with --file: changes cameras that are there into those of the file")
                        ->needs(file);
    options->camera.add_to(*create);
    // The file says all else.
    for (CLI::Option* other : create->get_options())
        if (other != name && other != file && other != replace && other != create->get_help_ptr())
            other->excludes(file);
    create->callback([options, &context] {
        context.action = [options, &context] {
            if (!options->file.empty())
                return create_from_file(context, options->file, options->name, options->replaces);
            if (options->name.empty()) return context.usage("camera create: give a NAME, or --file FILE");
            auto params = camera_params(options->camera, nullptr);
            if (!params) return context.usage(params.error().message);
            (*params)["name"] = options->name;
            if (!options->place.empty()) (*params)["place"] = options->place;
            if (auto put = put_calibration(options->camera, *params); !put) return context.fail(put.error());
            auto made = context.call("camera.create", *params);
            return made ? context.print(*made, short_text(*made)) : context.fail(made.error());
        };
    });
}

void add_set(CLI::App& camera, CliContext& context) {
    struct Options {
        std::string name;
        std::optional<double> seconds;
        CameraOptions camera;
    };
    auto options = std::make_shared<Options>();
    CLI::App* set = camera.add_subcommand(
        "set", "changes a camera; what is not given stays, but of outputs, of which all are given");
    set->add_option("NAME", options->name, "the camera")->required();
    set->add_option("--seconds", options->seconds, "world time in which pose and field of view get there");
    options->camera.add_to(*set);
    set->callback([options, &context] {
        context.action = [options, &context] {
            // Checked before anything is asked of the rig.
            const json stand_in = {{"position", {0, 0, 0}},
                                   {"orientation", {0, 0, 0, 1}},
                                   {"pan_deg", 0},
                                   {"tilt_deg", 0},
                                   {"roll_deg", 0}};
            auto checked = camera_params(options->camera, stand_in);
            if (!checked) return context.usage(checked.error().message);
            if (auto put = put_calibration(options->camera, *checked); !put) return context.fail(put.error());
            auto client = context.connect();
            if (!client) return context.fail(client.error());
            json present = nullptr;
            if (options->camera.has_pose()) {
                auto state = client->call("camera.get", {{"name", options->name}});
                if (!state) return context.fail(state.error());
                present = (*state).at("pose");
            }
            auto params = camera_params(options->camera, present);
            if (!params) return context.usage(params.error().message);
            if (auto put = put_calibration(options->camera, *params); !put) return context.fail(put.error());
            (*params)["name"] = options->name;
            if (options->seconds) (*params)["seconds"] = *options->seconds;
            auto changed = client->call("camera.set", *params);
            return changed ? context.print(*changed, short_text(*changed)) : context.fail(changed.error());
        };
    });
}

/// "/dev/video40, /dev/video41", of its outputs that are devices.
std::string devices_text(const json& camera) {
    std::string text;
    for (const json& output : camera.at("outputs"))
        if (output.contains("number"))
            text += (text.empty() ? "/dev/video" : ", /dev/video") + plain_text(output["number"]);
    return text.empty() ? "-" : text;
}

int list(const CliContext& context) {
    auto answer = context.call("camera.list");
    if (!answer) return context.fail(answer.error());
    std::vector<std::vector<std::string>> rows{{"NAME", "SIZE", "FPS", "VFOV", "POSITION", "READERS", "DEVICE"}};
    for (const json& camera : (*answer).at("cameras")) {
        rows.push_back({camera.at("name").get<std::string>(), size_text(camera), plain_text(camera.at("fps")),
                        plain_text(camera.at("vfov_deg")), vector_text(camera.at("world_pose").at("position")),
                        plain_text(camera.at("readers")), devices_text(camera)});
    }
    return context.print(*answer, table(rows));
}

}  // namespace

void add_camera_commands(CLI::App& app, CliContext& context) {
    CLI::App* camera = app.add_subcommand("camera", "creates, shows, changes and deletes cameras");
    camera->require_subcommand(1);
    add_create(*camera, context);
    add_set(*camera, context);
    camera->add_subcommand("list", "all cameras")->callback([&context] {
        context.action = [&context] { return list(context); };
    });

    add_calibration_command(*camera, context);

    auto name = std::make_shared<std::string>();
    CLI::App* get = camera->add_subcommand("get", "everything about a camera");
    get->add_option("NAME", *name, "the camera")->required();
    get->callback([name, &context] {
        context.action = [name, &context] {
            auto state = context.call("camera.get", {{"name", *name}});
            return state ? context.print(*state, long_text(*state)) : context.fail(state.error());
        };
    });
    CLI::App* remove = camera->add_subcommand("delete", "deletes a camera");
    remove->add_option("NAME", *name, "the camera")->required();
    remove->callback([name, &context] {
        context.action = [name, &context] {
            auto gone = context.call("camera.delete", {{"name", *name}});
            return gone ? context.print(*gone, *name + ": deleted") : context.fail(gone.error());
        };
    });
}

}  // namespace camrig::cli
