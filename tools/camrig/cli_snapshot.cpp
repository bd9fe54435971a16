#include <filesystem>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "core/base/base64.h"
#include "core/base/write_file.h"
#include "tools/camrig/cli_commands.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

std::string format_of(const std::filesystem::path& file) {
    std::string suffix = file.extension().string();
    for (char& c : suffix)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return suffix == ".png" ? "png" : suffix == ".jpg" || suffix == ".jpeg" ? "jpeg" : "";
}

}  // namespace

void add_snapshot_command(CLI::App& app, CliContext& context) {
    struct Options {
        std::string camera;
        std::filesystem::path file;
        std::optional<int> quality;
        std::optional<std::int64_t> min_ns;
    };
    auto options = std::make_shared<Options>();
    CLI::App* snapshot = app.add_subcommand("snapshot", "writes a camera's latest picture to a file");
    snapshot->add_option("NAME", options->camera, "the camera")->required();
    snapshot->add_option("-o,--output", options->file, "FILE.png or FILE.jpg")->required();
    snapshot->add_option("--quality", options->quality, "of JPEG, 1 to 100")->check(CLI::Range(1, 100));
    snapshot->add_option("--min-ns", options->min_ns, "world time that the picture must at least show");
    snapshot->callback([options, &context] {
        context.action = [options, &context] {
            const std::string format = format_of(options->file);
            if (format.empty())
                return context.usage("snapshot: " + options->file.string() + " must end in .png or .jpg");
            json params{{"camera", options->camera}, {"format", format}};
            if (options->quality && format == "png") return context.usage("snapshot: --quality is for .jpg");
            if (options->quality) params["quality"] = *options->quality;
            if (options->min_ns) params["min_ns"] = *options->min_ns;
            auto frame = context.call("frame.get", params);
            if (!frame) return context.fail(frame.error());
            auto bytes = base64_decode(frame->value("data", ""));
            if (!bytes) return context.fail(bytes.error());
            if (auto written = write_atomically(options->file, *bytes); !written) return context.fail(written.error());
            frame->erase("data");
            frame->erase("encoding");
            (*frame)["file"] = options->file.string();
            return context.print(*frame, options->file.string() + ": frame " + plain_text((*frame)["sequence"]) +
                                             " of " + options->camera + ", world time " +
                                             seconds_text((*frame)["time_ns"]));
        };
    });
}

}  // namespace camrig::cli
