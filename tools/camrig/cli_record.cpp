#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <ostream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <unistd.h>

#include "core/base/base64.h"
#include "core/base/field_of.h"
#include "core/base/rate.h"
#include "core/camera/exposure_times.h"
#include "core/codec/encoder.h"
#include "rtsp_out/http/npy.h"
#include "tools/camrig/cli_commands.h"
#include "tools/camrig/dataset/dataset.h"
#include "tools/camrig/dataset/mask_rle.h"

// `camrig record`: a client like any other. It steps the world from one due instant to the next and takes picture and
// truth of every camera that is due there, so that nothing is dropped however long a frame takes.
namespace camrig::cli {
namespace {

using nlohmann::json;

constexpr double default_seconds = 10.0;

struct RecordOptions {
    std::filesystem::path folder;
    std::vector<std::string> cameras;
    std::optional<double> seconds;
    std::optional<std::int64_t> frames;
    std::string format = "png";
    std::string depth;  ///< npy, png, or empty: none
    bool flow = false;
    bool masks = false;
    bool soiling = false;
    bool yolo = false;
    bool repairs = false;
};

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

struct RecordedCamera {
    std::string name;
    Rate rate;
    camera::ExposureTimes times;

    TimeNs next_due_ns(TimeNs after_ns) const { return times.time_of_frame(times.frames_until(after_ns)); }
};

ImageSize size_in(const json& truth) {
    return {truth.at("size").at(0).get<int>(), truth.at("size").at(1).get<int>()};
}

void put_before(std::vector<std::byte>& bytes, const std::string& head) {
    const auto of_head = std::as_bytes(std::span(head));
    bytes.insert(bytes.begin(), of_head.begin(), of_head.end());
}

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

class Recorder {
public:
    Recorder(const CliContext& context, client::RpcClient client, const RecordOptions& options)
        : context_(context), client_(std::move(client)), options_(options) {}

    Result<json> run(Progress& progress);

private:
    Result<void> choose_cameras();
    Result<void> hold_world();
    Result<void> let_world_go();
    Result<void> begin_dataset();
    Result<std::map<std::string, TimeNs>> shown_after(TimeNs world_ns);
    Result<std::int64_t> record(Progress& progress);
    Result<void> take(const RecordedCamera& camera, TimeNs instant_ns);
    Result<std::vector<std::byte>> picture(const json& params, const json& truth);
    Result<DatasetWriter::FrameFile> depth(const RecordedCamera& camera, const json& truth);
    Result<DatasetWriter::FrameFile> flow(const RecordedCamera& camera, const json& truth);
    Result<DatasetWriter::FrameFile> soiling(const RecordedCamera& camera, const json& truth);
    Result<DatasetWriter::FrameFile> masks(const RecordedCamera& camera, json& truth);

    const CliContext& context_;
    client::RpcClient client_;
    const RecordOptions& options_;
    std::vector<RecordedCamera> cameras_;
    std::optional<DatasetWriter> writer_;
    json names_ = json::array();
    json world_;
    bool resumes_ = false;
};

Result<void> Recorder::choose_cameras() {
    const auto list = client_.call("camera.list");
    if (!list) return std::unexpected(list.error());
    for (const json& camera : list->at("cameras")) {
        const std::string name = camera.at("name");
        if (!options_.cameras.empty() && std::ranges::find(options_.cameras, name) == options_.cameras.end()) continue;
        const json& fps = camera.at("fps");
        const auto rate = fps.is_string() ? Rate::parse(fps.get<std::string>()) : Rate::from_number(fps.get<double>());
        if (!rate) return std::unexpected(rate.error());
        std::optional<camera::ClockSpec> clock;
        if (const json& told = camera.at("clock"); !told.is_null()) {
            const auto read = read_all<camera::ClockSpec>(told, "clock");
            if (!read) return std::unexpected(read.error());
            clock = *read;
        }
        cameras_.push_back({name, *rate, {*rate, clock}});
        names_.push_back(name);
    }
    for (const std::string& name : options_.cameras)
        if (std::ranges::find(cameras_, name, &RecordedCamera::name) == cameras_.end())
            return error(ErrorKind::not_found, "there is no camera '" + name + "'");
    if (cameras_.empty()) return error(ErrorKind::not_found, "the rig has no camera to record");
    return {};
}

/// A world that runs is stopped for the recording and runs on after it.
Result<void> Recorder::hold_world() {
    auto status = client_.call("world.status");
    if (!status) return std::unexpected(status.error());
    if (status->at("mode") == "realtime" && !status->at("paused").get<bool>()) {
        if (auto paused = client_.call("world.pause"); !paused) return std::unexpected(paused.error());
        resumes_ = true;
        status = client_.call("world.status");
        if (!status) return std::unexpected(status.error());
    }
    world_ = std::move(*status);
    return {};
}

/// On a connection of its own where the first was lost: the world must not stand for that.
Result<void> Recorder::let_world_go() {
    const auto resumed = client_.is_usable() ? client_.call("world.resume") : context_.call("world.resume");
    if (!resumed) return std::unexpected(resumed.error());
    return {};
}

/// The bytes of frame.get; its frame must be the truth's.
Result<std::vector<std::byte>> Recorder::picture(const json& params, const json& truth) {
    const auto frame = client_.call("frame.get", params);
    if (!frame) return std::unexpected(frame.error());
    if (frame->at("time_ns") != truth.at("time_ns") || frame->at("sequence") != truth.at("sequence"))
        return error(ErrorKind::unavailable, "camera " + params.at("camera").get<std::string>() +
                                                 ": somebody else moves the world or changes the camera; a recording "
                                                 "needs both for itself");
    return base64_decode(frame->at("data").get<std::string>());
}

Result<DatasetWriter::FrameFile> Recorder::depth(const RecordedCamera& camera, const json& truth) {
    const bool is_npy = options_.depth == "npy";
    auto bytes = picture({{"camera", camera.name},
                          {"min_ns", truth.at("time_ns")},
                          {"kind", "depth"},
                          {"format", is_npy ? "raw" : "png"}},
                         truth);
    if (!bytes) return std::unexpected(bytes.error());
    if (is_npy) put_before(*bytes, http::npy_float32_head(size_in(truth)));
    return DatasetWriter::FrameFile{"depth", "." + options_.depth, std::move(*bytes)};
}

Result<DatasetWriter::FrameFile> Recorder::flow(const RecordedCamera& camera, const json& truth) {
    auto bytes =
        picture({{"camera", camera.name}, {"min_ns", truth.at("time_ns")}, {"kind", "flow"}, {"format", "raw"}}, truth);
    if (!bytes) return std::unexpected(bytes.error());
    put_before(*bytes, http::npy_float32_head(size_in(truth), 2));
    return DatasetWriter::FrameFile{"flow", ".npy", std::move(*bytes)};
}

Result<DatasetWriter::FrameFile> Recorder::soiling(const RecordedCamera& camera, const json& truth) {
    auto bytes = picture(
        {{"camera", camera.name}, {"min_ns", truth.at("time_ns")}, {"kind", "soiling"}, {"format", "png"}}, truth);
    if (!bytes) return std::unexpected(bytes.error());
    return DatasetWriter::FrameFile{"soiling", ".png", std::move(*bytes)};
}

/// The instance picture; the masks of its objects go into the truth.
Result<DatasetWriter::FrameFile> Recorder::masks(const RecordedCamera& camera, json& truth) {
    auto bytes = picture(
        {{"camera", camera.name}, {"min_ns", truth.at("time_ns")}, {"kind", "instance"}, {"format", "raw"}}, truth);
    if (!bytes) return std::unexpected(bytes.error());
    const ImageSize size = size_in(truth);
    if (static_cast<std::int64_t>(bytes->size()) != size.pixels() * 4)
        return error(ErrorKind::internal, "camera " + camera.name + ": an instance picture of another size");
    std::vector<std::uint32_t> ids(bytes->size() / 4);
    std::memcpy(ids.data(), bytes->data(), bytes->size());
    auto masks = coco_masks(ids, size);
    for (json& object : truth.at("objects")) {
        const auto mask = masks.find(object.at("id").get<std::uint32_t>());
        if (mask != masks.end())
            object["segmentation"] = {{"size", {size.height, size.width}}, {"counts", std::move(mask->second)}};
    }
    frame::FrameInfo info;
    info.camera = std::make_shared<const std::string>(camera.name);
    info.size = size;
    info.kind = frame::FrameKind::instance;
    info.format = frame::PixelFormat::id32;
    auto encoder = codec::create_png_encoder();
    if (!encoder) return std::unexpected(encoder.error());
    const auto png = (*encoder)->encode(frame::Frame(std::move(info), std::move(*bytes)));
    if (!png) return std::unexpected(png.error());
    return DatasetWriter::FrameFile{"instance", ".png", **png};
}

Result<void> Recorder::take(const RecordedCamera& camera, TimeNs instant_ns) {
    auto truth = client_.call("truth.get", {{"camera", camera.name}, {"min_ns", instant_ns}});
    if (!truth) return std::unexpected(truth.error());
    if (truth->at("time_ns") != instant_ns)
        return error(ErrorKind::unavailable,
                     "camera " + camera.name + ": somebody else moves the world; a recording needs it for itself");
    const auto color = picture({{"camera", camera.name}, {"min_ns", instant_ns}, {"format", options_.format}}, *truth);
    if (!color) return std::unexpected(color.error());
    std::vector<DatasetWriter::FrameFile> further;
    if (!options_.depth.empty()) {
        auto file = depth(camera, *truth);
        if (!file) return std::unexpected(file.error());
        further.push_back(std::move(*file));
    }
    if (options_.flow) {
        auto file = flow(camera, *truth);
        if (!file) return std::unexpected(file.error());
        further.push_back(std::move(*file));
    }
    if (options_.masks) {
        auto file = masks(camera, *truth);
        if (!file) return std::unexpected(file.error());
        further.push_back(std::move(*file));
    }
    if (options_.soiling) {
        auto file = soiling(camera, *truth);
        if (!file) return std::unexpected(file.error());
        further.push_back(std::move(*file));
    }
    return writer_->add(*truth, *color, further, fmt::format("{}", camera.rate.hertz()));
}

Result<void> Recorder::begin_dataset() {
    const json description{{"scene", world_.at("scene")}, {"seed", world_.at("seed")}, {"cameras", names_},
                           {"depth", options_.depth},     {"flow", options_.flow},     {"masks", options_.masks},
                           {"soiling", options_.soiling}, {"yolo", options_.yolo}};
    auto writer = DatasetWriter::create(options_.folder, description, options_.format == "png" ? ".png" : ".jpg");
    if (!writer) return std::unexpected(writer.error());
    writer_ = std::move(*writer);
    return {};
}

/// World times of the pictures that came after one of ours, by camera. One that exposes for longer than a period leaves
/// instants of its rate out; one that an event gave another clock has its own.
Result<std::map<std::string, TimeNs>> Recorder::shown_after(TimeNs world_ns) {
    const auto listed = client_.call("camera.list");
    if (!listed) return std::unexpected(listed.error());
    std::map<std::string, TimeNs> shown;
    for (const json& camera : listed->at("cameras"))
        if (const auto at_ns = camera.at("applied_ns").get<TimeNs>(); at_ns > world_ns)
            shown.emplace(camera.at("name").get<std::string>(), at_ns);
    return shown;
}

Result<std::int64_t> Recorder::record(Progress& progress) {
    if (auto begun = begin_dataset(); !begun) return std::unexpected(begun.error());
    const TimeNs start_ns = world_.at("world_ns").get<TimeNs>();
    const double seconds = options_.seconds.value_or(options_.frames ? 1e9 : default_seconds);
    const TimeNs end_ns = start_ns + static_cast<TimeNs>(seconds * 1e9);
    std::int64_t frames = 0, instants = 0;
    for (TimeNs now_ns = start_ns; stop_asked == 0;) {
        TimeNs next_ns = max_time_ns;
        for (const RecordedCamera& camera : cameras_) next_ns = std::min(next_ns, camera.next_due_ns(now_ns));
        if (next_ns > end_ns || (options_.frames && instants >= *options_.frames)) break;
        const auto stepped = client_.call("world.step", {{"nanoseconds", next_ns - now_ns}});
        if (!stepped) return std::unexpected(stepped.error());
        const auto shown = shown_after(now_ns);
        if (!shown) return std::unexpected(shown.error());
        const std::int64_t before = frames;
        for (const RecordedCamera& camera : cameras_) {
            const auto found = shown->find(camera.name);
            if (found == shown->end()) continue;
            if (auto taken = take(camera, found->second); !taken) return std::unexpected(taken.error());
            ++frames;
        }
        now_ns = next_ns;
        instants += frames > before ? 1 : 0;
        const double share = options_.frames ? static_cast<double>(instants) / static_cast<double>(*options_.frames)
                                             : static_cast<double>(now_ns - start_ns) / (seconds * 1e9);
        progress.show(share, frames);
    }
    return frames;
}

Result<json> Recorder::run(Progress& progress) {
    if (auto chosen = choose_cameras(); !chosen) return std::unexpected(chosen.error());
    Result<std::int64_t> frames = 0;
    try {
        if (const auto held = hold_world(); !held)
            frames = std::unexpected(held.error());
        else
            frames = record(progress);
    } catch (const json::exception& problem) {
        frames = std::unexpected(unexpected_answer(problem));
    } catch (const std::exception& problem) {
        frames = error(ErrorKind::internal, problem.what());
    }
    if (resumes_) {
        if (auto resumed = let_world_go(); !resumed && frames) frames = std::unexpected(resumed.error());
    }
    // What came before an error is a data set too.
    if (writer_)
        if (auto finished = finish_dataset(options_.folder); !finished && frames) frames = finished;
    if (!frames) return std::unexpected(frames.error());
    return json{{"folder", options_.folder.string()}, {"cameras", names_}, {"frames", *frames}};
}

int record_or_repair(const CliContext& context, const RecordOptions& options) {
    if (options.repairs) {
        const auto frames = finish_dataset(options.folder);
        if (!frames) return context.fail(frames.error());
        return context.print({{"folder", options.folder.string()}, {"frames", *frames}},
                             options.folder.string() + ": " + std::to_string(*frames) + " frames");
    }
    auto client = context.connect();
    if (!client) return context.fail(client.error());
    const StopSignals signals;
    Result<json> done = [&] {
        Progress progress(context.err, !context.json);
        return Recorder(context, std::move(*client), options).run(progress);
    }();
    if (!done) return context.fail(done.error());
    return context.print(*done, options.folder.string() + ": " + plain_text((*done)["frames"]) + " frames of " +
                                    std::to_string((*done)["cameras"].size()) +
                                    " cameras, with labels for COCO, "
                                    "MOTChallenge and KITTI");
}

}  // namespace

void add_record_command(CLI::App& app, CliContext& context) {
    auto options = std::make_shared<RecordOptions>();
    CLI::App* record = app.add_subcommand(
        "record", "writes a data set: every due frame with labels; steps the world, a running one stands meanwhile");
    record->add_option("DIR", options->folder, "folder of the data set")->required();
    record->add_option("--cameras", options->cameras, "NAME,NAME,...; default: all")->delimiter(',');
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
    record->callback(
        [options, &context] { context.action = [options, &context] { return record_or_repair(context, *options); }; });
}

}  // namespace camrig::cli
