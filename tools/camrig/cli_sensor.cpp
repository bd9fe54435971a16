#include <memory>

#include <CLI/CLI.hpp>

#include "core/sensor/photon_transfer.h"
#include "tools/camrig/cli_commands.h"
#include "tools/camrig/raw_picture_file.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

struct FitOptions {
    std::vector<std::string> files;
    int bits = 16;
};

int fit(const CliContext& context, const FitOptions& options) {
    std::vector<sensor::RawPicture> pictures;
    for (const std::string& file : options.files) {
        auto read = read_raw_pictures(file);
        if (!read) return context.fail(read.error());
        std::ranges::move(*read, std::back_inserter(pictures));
    }
    const auto fitted = fit_photon_transfer(pictures, options.bits);
    if (!fitted) return context.fail(fitted.error());
    // What camera.set takes as `sensor`: its gain follows from full well, black level and bits.
    const json found{{"bits", options.bits},
                     {"black_level", fitted->black_level},
                     {"full_well_e", fitted->full_well_e},
                     {"read_noise_e", fitted->read_noise_e}};
    return context.print(found, found.dump());
}

}  // namespace

void add_sensor_command(CLI::App& app, CliContext& context) {
    CLI::App* command = app.add_subcommand("sensor", "figures of a sensor");
    command->require_subcommand(1);
    auto options = std::make_shared<FitOptions>();
    CLI::App* fitting = command->add_subcommand(
        "fit", "full well, read noise and black level from raw pictures of an own camera (photon transfer), as JSON");
    fitting
        ->add_option("PICTURES", options->files,
                     "grey .png or .npy of 8 or 16 bits: two dark pictures, then two of each of several evenly lit "
                     "greys; an .npy may hold both of a pair")
        ->required()
        ->expected(1, 256);
    fitting->add_option("--bits", options->bits, "of the camera's converter; default 16")->check(CLI::Range(8, 16));
    fitting->callback([options, &context] { context.action = [options, &context] { return fit(context, *options); }; });
}

}  // namespace camrig::cli
