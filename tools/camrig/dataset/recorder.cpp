#include "tools/camrig/dataset/recorder.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <span>

#include <fmt/format.h>

#include "core/base/base64.h"
#include "core/base/field_of.h"
#include "core/codec/encoder.h"
#include "rtsp_out/http/npy.h"
#include "tools/camrig/dataset/mask_rle.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

constexpr double default_seconds = 10.0;

ImageSize size_in(const json& truth) {
    return {truth.at("size").at(0).get<int>(), truth.at("size").at(1).get<int>()};
}

void put_before(std::vector<std::byte>& bytes, const std::string& head) {
    const auto of_head = std::as_bytes(std::span(head));
    bytes.insert(bytes.begin(), of_head.begin(), of_head.end());
}

}  // namespace

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
        if (std::ranges::find(cameras_, name, &Camera::name) == cameras_.end())
            return error(ErrorKind::not_found, "there is no camera '" + name + "'");
    if (cameras_.empty()) return error(ErrorKind::not_found, "the rig has no camera to record");
    return {};
}

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

/// The bytes of frame.get, of the camera and instant that a truth is of.
Result<std::vector<std::byte>> Recorder::picture(json params, const json& truth) {
    params["camera"] = truth.at("camera");
    params["min_ns"] = truth.at("time_ns");
    const auto frame = client_.call("frame.get", params);
    if (!frame) return std::unexpected(frame.error());
    if (frame->at("time_ns") != truth.at("time_ns") || frame->at("sequence") != truth.at("sequence"))
        return error(ErrorKind::unavailable, "camera " + truth.at("camera").get<std::string>() +
                                                 ": somebody else moves the world or changes the camera; a recording "
                                                 "needs both for itself");
    return base64_decode(frame->at("data").get<std::string>());
}

Result<DatasetWriter::FrameFile> Recorder::depth(const json& truth) {
    const bool is_npy = options_.depth == "npy";
    auto bytes = picture({{"kind", "depth"}, {"format", is_npy ? "raw" : "png"}}, truth);
    if (!bytes) return std::unexpected(bytes.error());
    if (is_npy) put_before(*bytes, http::npy_float32_head(size_in(truth)));
    return DatasetWriter::FrameFile{"depth", "." + options_.depth, std::move(*bytes)};
}

Result<DatasetWriter::FrameFile> Recorder::flow(const json& truth) {
    auto bytes = picture({{"kind", "flow"}, {"format", "raw"}}, truth);
    if (!bytes) return std::unexpected(bytes.error());
    put_before(*bytes, http::npy_float32_head(size_in(truth), 2));
    return DatasetWriter::FrameFile{"flow", ".npy", std::move(*bytes)};
}

Result<DatasetWriter::FrameFile> Recorder::soiling(const json& truth) {
    auto bytes = picture({{"kind", "soiling"}, {"format", "png"}}, truth);
    if (!bytes) return std::unexpected(bytes.error());
    return DatasetWriter::FrameFile{"soiling", ".png", std::move(*bytes)};
}

/// The instance picture; the masks of its objects go into the truth.
Result<DatasetWriter::FrameFile> Recorder::masks(json& truth) {
    auto bytes = picture({{"kind", "instance"}, {"format", "raw"}}, truth);
    if (!bytes) return std::unexpected(bytes.error());
    const std::string camera = truth.at("camera");
    const ImageSize size = size_in(truth);
    if (static_cast<std::int64_t>(bytes->size()) != size.pixels() * 4)
        return error(ErrorKind::internal, "camera " + camera + ": an instance picture of another size");
    std::vector<std::uint32_t> ids(bytes->size() / 4);
    std::memcpy(ids.data(), bytes->data(), bytes->size());
    auto masks = coco_masks(ids, size);
    for (json& object : truth.at("objects")) {
        const auto mask = masks.find(object.at("id").get<std::uint32_t>());
        if (mask != masks.end())
            object["segmentation"] = {{"size", {size.height, size.width}}, {"counts", std::move(mask->second)}};
    }
    frame::FrameInfo info;
    info.camera = std::make_shared<const std::string>(camera);
    info.size = size;
    info.kind = frame::FrameKind::instance;
    info.format = frame::PixelFormat::id32;
    auto encoder = codec::create_png_encoder();
    if (!encoder) return std::unexpected(encoder.error());
    const auto png = (*encoder)->encode(frame::Frame(std::move(info), std::move(*bytes)));
    if (!png) return std::unexpected(png.error());
    return DatasetWriter::FrameFile{"instance", ".png", **png};
}

Result<void> Recorder::take(const Camera& camera, TimeNs instant_ns) {
    auto truth = client_.call("truth.get", {{"camera", camera.name}, {"min_ns", instant_ns}});
    if (!truth) return std::unexpected(truth.error());
    if (truth->at("time_ns") != instant_ns)
        return error(ErrorKind::unavailable,
                     "camera " + camera.name + ": somebody else moves the world; a recording needs it for itself");
    const auto color = picture({{"format", options_.format}}, *truth);
    if (!color) return std::unexpected(color.error());
    std::vector<DatasetWriter::FrameFile> further;
    const auto add = [&](Result<DatasetWriter::FrameFile> file) -> Result<void> {
        if (!file) return std::unexpected(file.error());
        further.push_back(std::move(*file));
        return {};
    };
    Result<void> added;
    if (!options_.depth.empty()) added = add(depth(*truth));
    if (added && options_.flow) added = add(flow(*truth));
    if (added && options_.masks) added = add(masks(*truth));
    if (added && options_.soiling) added = add(soiling(*truth));
    if (!added) return std::unexpected(added.error());
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

Result<std::int64_t> Recorder::record(const GoesOn& goes_on) {
    if (auto begun = begin_dataset(); !begun) return std::unexpected(begun.error());
    const TimeNs start_ns = world_.at("world_ns").get<TimeNs>();
    const double seconds = options_.seconds.value_or(options_.frames ? 1e9 : default_seconds);
    const TimeNs end_ns = start_ns + static_cast<TimeNs>(seconds * 1e9);
    std::int64_t frames = 0, instants = 0;
    double share = 0.0;
    for (TimeNs now_ns = start_ns; goes_on(share, frames);) {
        TimeNs next_ns = max_time_ns;
        for (const Camera& camera : cameras_) next_ns = std::min(next_ns, camera.next_due_ns(now_ns));
        if (next_ns > end_ns || (options_.frames && instants >= *options_.frames)) break;
        const auto stepped = client_.call("world.step", {{"nanoseconds", next_ns - now_ns}});
        if (!stepped) return std::unexpected(stepped.error());
        const auto shown = shown_after(now_ns);
        if (!shown) return std::unexpected(shown.error());
        const std::int64_t before = frames;
        for (const Camera& camera : cameras_) {
            const auto found = shown->find(camera.name);
            if (found == shown->end()) continue;
            if (auto taken = take(camera, found->second); !taken) return std::unexpected(taken.error());
            ++frames;
        }
        now_ns = next_ns;
        instants += frames > before ? 1 : 0;
        share = options_.frames ? static_cast<double>(instants) / static_cast<double>(*options_.frames)
                                : static_cast<double>(now_ns - start_ns) / (seconds * 1e9);
    }
    return frames;
}

Result<json> Recorder::run(const GoesOn& goes_on) {
    if (auto chosen = choose_cameras(); !chosen) return std::unexpected(chosen.error());
    Result<std::int64_t> frames = 0;
    try {
        if (const auto held = hold_world(); !held)
            frames = std::unexpected(held.error());
        else
            frames = record(goes_on);
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

}  // namespace camrig::cli
