#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <memory>
#include <ostream>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "tools/camrig/cli_commands.h"
#include "tools/camrig/dataset/recorder.h"

// `camrig record`: its options, its progress, and how it is stopped.
namespace camrig::cli {
namespace {

volatile std::sig_atomic_t stop_asked = 0;

/// While it lives, Ctrl-C, `kill` and a terminal that goes (but below nohup) end the recording after the frame in work,
/// in order.
class StopSignals {
public:
    StopSignals() {
        stop_asked = 0;
        struct sigaction stop{};
        stop.sa_handler = [](int) { stop_asked = 1; };
        stop.sa_flags = SA_RESTART;
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            ::sigaction(numbers[i], nullptr, &before_[i]);
            if (numbers[i] != SIGHUP || before_[i].sa_handler != SIG_IGN) ::sigaction(numbers[i], &stop, nullptr);
        }
    }
    ~StopSignals() {
        for (std::size_t i = 0; i < numbers.size(); ++i) ::sigaction(numbers[i], &before_[i], nullptr);
    }
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

private:
    static constexpr std::array numbers{SIGINT, SIGTERM, SIGHUP};
    std::array<struct sigaction, numbers.size()> before_{};
};

/// What was done so far, on one line of the terminal; silent elsewhere.
class Progress {
public:
    Progress(std::ostream& err, bool is_wanted) : err_(err), is_shown_(is_wanted && ::isatty(STDERR_FILENO) == 1) {}
    ~Progress() {
        if (is_shown_) err_ << std::endl;
    }
    void show(double share, std::int64_t frames) {
        if (!is_shown_) return;
        constexpr int width = 40;
        const int full = static_cast<int>(width * std::clamp(share, 0.0, 1.0));
        char text[128];
        std::snprintf(text, sizeof text, "\r[%s%s] %3.0f %%  %lld frames", std::string(full, '#').c_str(),
                      std::string(width - full, '.').c_str(), 100.0 * share, static_cast<long long>(frames));
        err_ << text << std::flush;
    }

private:
    std::ostream& err_;
    bool is_shown_;
};

int repair(const CliContext& context, const std::filesystem::path& folder) {
    const auto frames = finish_dataset(folder);
    if (!frames) return context.fail(frames.error());
    return context.print({{"folder", folder.string()}, {"frames", *frames}},
                         folder.string() + ": " + std::to_string(*frames) + " frames");
}

int record_dataset(const CliContext& context, const RecordOptions& options) {
    auto client = context.connect();
    if (!client) return context.fail(client.error());
    const StopSignals signals;
    Result<json> done = [&] {
        Progress progress(context.err, !context.json);
        return Recorder(context, std::move(*client), options).run([&](double share, std::int64_t frames) {
            progress.show(share, frames);
            return stop_asked == 0;
        });
    }();
    if (!done) return context.fail(done.error());
    return context.print(*done, options.folder.string() + ": " + plain_text((*done)["frames"]) + " frames of " +
                                    std::to_string((*done)["cameras"].size()) +
                                    " cameras, with labels for COCO, "
                                    "MOTChallenge and KITTI");
}

}  // namespace

void add_record_command(CLI::App& app, CliContext& context) {
    struct Options : RecordOptions {
        bool repairs = false;
    };
    auto options = std::make_shared<Options>();
    CLI::App* record = app.add_subcommand(
        "record", "writes a data set: every due frame with labels; steps the world, a running one stands meanwhile");
    record->add_option("DIR", options->folder, "folder of the data set")->required();
    record->add_option("--cameras", options->cameras, "NAME,NAME,...; default: all")
        ->delimiter(',')
        ->allow_extra_args(false);
    auto* seconds =
        record->add_option("--seconds", options->seconds, "of world time; default 10")->check(CLI::Range(0.0, 1e9));
    record->add_option("--frames", options->frames, "instants instead of seconds")
        ->check(CLI::Range(std::int64_t{1}, std::int64_t{1'000'000'000}))
        ->excludes(seconds);
    record->add_option("--format", options->format, "of pictures: png or jpeg")->check(CLI::IsMember({"png", "jpeg"}));
    record->add_option("--depth", options->depth, "too: npy (float32, metres) or png (16 bit, millimetres)")
        ->check(CLI::IsMember({"npy", "png"}));
    record->add_flag("--flow", options->flow, "optical flow too (npy, float32, pixels until the camera's next frame)");
    record->add_flag("--masks", options->masks, "instance pictures (16-bit PNG of ids) and COCO masks too");
    record->add_flag("--soiling", options->soiling, "what dirt and covers on the lens hide too (8-bit PNG)");
    record->add_flag("--yolo", options->yolo, "YOLO labels too");
    record->add_flag("--repair", options->repairs, "completes a data set whose recording was killed, without a rig");
    record->callback([options, &context] {
        context.action = [options, &context] {
            return options->repairs ? repair(context, options->folder) : record_dataset(context, *options);
        };
    });
}

}  // namespace camrig::cli
