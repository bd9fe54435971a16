#include "core/stream/local_frame_bus.h"

#include <algorithm>

#include "core/base/out_of_memory.h"

namespace camrig::stream {
namespace {

Error unknown_camera(std::string_view name, const std::vector<CameraStream>& known) {
    std::string names;
    for (const auto& camera : known) {
        if (names.size() > 200) {
            names += ", ...";
            break;
        }
        names += (names.empty() ? "" : ", ") + camera.name;
    }
    return {ErrorKind::not_found, "no camera '" + std::string(name.substr(0, 60)) + "'; " +
                                      (names.empty() ? "there are none" : "there are: " + names)};
}

/// Numbers are what they are: they are not scaled, and only the camera's own layout is there.
Result<void> check_numbers(const CameraStream& camera, const MediaFormat& format) {
    if (format.number_bits == 0) return {};
    const bool is_own_size = format.size == ImageSize{} || format.size == camera.size;
    if (camera.numbers && camera.numbers->pixels == format.pixels && is_own_size && format.codec == codec::Codec::raw)
        return {};
    return error(ErrorKind::invalid_argument,
                 "camera " + camera.name + " has no sensor whose numbers are " + describe(format) +
                     (camera.numbers ? "; it gives " + std::string(to_string(camera.numbers->pixels)) + " of " +
                                           camera.size.to_string()
                                     : std::string()));
}

}  // namespace

LocalFrameBus::LocalFrameBus(Options options)
    : options_(std::move(options)), pool_(std::make_unique<WorkerPool>(options_.workers, options_.max_jobs)) {}

LocalFrameBus::~LocalFrameBus() {
    {
        std::lock_guard lock(mutex_);
        for (auto& [id, camera] : cameras_) end_outputs(camera, {ErrorKind::unavailable, "the rig shuts down"});
    }
    pool_.reset();
}

LocalFrameBus::Cameras::iterator LocalFrameBus::find_locked(std::string_view name) {
    return std::ranges::find_if(cameras_, [&](const auto& entry) { return entry.second.stream.name == name; });
}

Result<Subscription> LocalFrameBus::subscribe(std::string_view camera, const MediaFormat& format,
                                              SubscribeOptions options, std::shared_ptr<Sink> sink,
                                              std::function<void(Error)> on_end) {
    auto reader = std::make_shared<Reader>();
    reader->stats = std::make_shared<ReaderStats>();
    reader->stats->kind = options.kind;
    reader->stats->peer = options.peer;
    reader->options = std::move(options);
    reader->sink = std::move(sink);
    reader->on_end = std::move(on_end);

    auto transcoder = Transcoder::create(format, options_.pool, timers_);
    if (!transcoder) return std::unexpected(transcoder.error());

    std::unique_lock lock(mutex_);
    const auto found = find_locked(camera);
    if (found == cameras_.end()) {
        lock.unlock();
        return std::unexpected(unknown_camera(camera, cameras()));
    }
    Camera& entry = found->second;
    if (auto good = check_numbers(entry.stream, format); !good) return std::unexpected(good.error());
    std::size_t readers = 0;
    for (const auto& [key, output] : entry.outputs) readers += output->reader_count();
    if (readers >= max_readers_per_camera) {
        return error(ErrorKind::resource_exhausted, "camera " + entry.stream.name + " has " + std::to_string(readers) +
                                                        " readers already; close some");
    }
    auto& output = entry.outputs[format];
    if (!output) {
        if (entry.outputs.size() > max_outputs_per_camera) {
            entry.outputs.erase(format);
            return error(ErrorKind::resource_exhausted,
                         "camera " + entry.stream.name + " is read in " + std::to_string(max_outputs_per_camera) +
                             " different formats already; use one of them, e.g. the default quality");
        }
        output = std::make_shared<Output>(entry.stream, std::move(*transcoder), *pool_, log_);
    }
    output->attach(reader);
    return Subscription([this, id = found->first, format, output, reader] { detach(id, format, output, reader); });
}

void LocalFrameBus::detach(CameraId id, const MediaFormat& format, const std::shared_ptr<Output>& output,
                           const std::shared_ptr<Reader>& reader) {
    if (!output->detach(reader)) return;
    std::lock_guard lock(mutex_);
    const auto camera = cameras_.find(id);
    if (camera == cameras_.end()) return;
    const auto entry = camera->second.outputs.find(format);
    // Somebody may have attached, or a new output may stand here, since the last reader left.
    if (entry != camera->second.outputs.end() && entry->second == output && output->reader_count() == 0)
        camera->second.outputs.erase(entry);
}

std::vector<CameraStream> LocalFrameBus::cameras() const {
    std::lock_guard lock(mutex_);
    std::vector<CameraStream> all;
    for (const auto& [id, camera] : cameras_) all.push_back(camera.stream);
    return all;
}

Result<CameraStream> LocalFrameBus::find(std::string_view camera) const {
    const auto all = cameras();
    const auto found = std::ranges::find(all, camera, &CameraStream::name);
    if (found == all.end()) return std::unexpected(unknown_camera(camera, all));
    return *found;
}

void LocalFrameBus::add_observer(CameraObserver* observer) {
    std::lock_guard lock(observers_mutex_);
    observers_.push_back(observer);
    for (const auto& camera : cameras()) observer->camera_added(camera);
}

void LocalFrameBus::remove_observer(CameraObserver* observer) {
    std::lock_guard lock(observers_mutex_);
    std::erase(observers_, observer);
}

void LocalFrameBus::note_refused(std::string_view camera, std::string_view output, std::string_view peer) {
    log_.add({.kind = ReaderEventKind::refused,
              .camera = std::string(camera),
              .output = std::string(output),
              .peer = std::string(peer)});
}

void LocalFrameBus::add_camera(const CameraStream& camera) {
    std::lock_guard observers_lock(observers_mutex_);
    {
        std::lock_guard lock(mutex_);
        cameras_[camera.id].stream = camera;
    }
    for (auto* observer : observers_) observer->camera_added(camera);
}

void LocalFrameBus::change_camera(const CameraStream& camera) {
    std::lock_guard observers_lock(observers_mutex_);
    {
        std::lock_guard lock(mutex_);
        Camera& entry = cameras_.at(camera.id);
        if (entry.stream.size != camera.size) {
            end_outputs(entry, {ErrorKind::unavailable, "camera " + camera.name + " now has size " +
                                                            camera.size.to_string() + "; open it again"});
        } else if (entry.stream.numbers != camera.numbers) {
            end_numbers(entry,
                        {ErrorKind::unavailable, "camera " + camera.name + " has another sensor; open it again"});
        }
        note_doors(entry.stream, camera);
        entry.stream = camera;
    }
    for (auto* observer : observers_) observer->camera_changed(camera);
}

void LocalFrameBus::note_doors(const CameraStream& before, const CameraStream& now) {
    const auto has = [](const CameraStream& camera, fault::Output output, std::string_view name) {
        const bool is_of_all = output == fault::Output::mjpeg || output == fault::Output::rtsp;
        return is_of_all || std::ranges::find(camera.outputs, name, &OutputSpec::kind) != camera.outputs.end();
    };
    for (const auto& [output, name] : names_of(std::type_identity<fault::Output>{})) {
        const bool is_closed = now.standing.refuses(name);
        if (is_closed == before.standing.refuses(name) || !(has(before, output, name) || has(now, output, name)))
            continue;
        log_.add({.kind = is_closed ? ReaderEventKind::closed : ReaderEventKind::open,
                  .camera = now.name,
                  .output = std::string(name)});
    }
}

void LocalFrameBus::adjust_camera(const CameraStream& camera) {
    std::lock_guard lock(observers_mutex_);
    for (auto* observer : observers_) observer->camera_adjusted(camera);
}

void LocalFrameBus::remove_camera(CameraId id) {
    std::lock_guard observers_lock(observers_mutex_);
    CameraStream gone;
    {
        std::lock_guard lock(mutex_);
        const auto found = cameras_.find(id);
        CHECK(found != cameras_.end());
        gone = found->second.stream;
        end_outputs(found->second, {ErrorKind::not_found, "camera " + gone.name + " was deleted"});
        cameras_.erase(found);
    }
    for (auto* observer : observers_) observer->camera_removed(gone);
}

void LocalFrameBus::end_outputs(Camera& camera, const Error& why) {
    for (auto& [format, output] : camera.outputs) output->end(why);
    camera.outputs.clear();
}

void LocalFrameBus::end_numbers(Camera& camera, const Error& why) {
    std::erase_if(camera.outputs, [&](const auto& entry) {
        const bool is_of_numbers = entry.first.number_bits != 0;
        if (is_of_numbers) entry.second->end(why);
        return is_of_numbers;
    });
}

frame::PixelFormats LocalFrameBus::wanted(CameraId id, TimeNs world_ns) const {
    std::lock_guard lock(mutex_);
    frame::PixelFormats formats;
    const auto found = cameras_.find(id);
    if (found == cameras_.end()) return formats;
    for (const auto& [format, output] : found->second.outputs) {
        if (output->wants(world_ns)) formats.add(output->source());
    }
    return formats;
}

std::size_t LocalFrameBus::reader_count(CameraId id) const {
    std::lock_guard lock(mutex_);
    const auto found = cameras_.find(id);
    std::size_t readers = 0;
    if (found != cameras_.end())
        for (const auto& [format, output] : found->second.outputs) readers += output->reader_count();
    return readers;
}

std::uint64_t LocalFrameBus::miss(CameraId id, const MissedFrames& frames, DropReason reason) {
    std::lock_guard lock(mutex_);
    const auto found = cameras_.find(id);
    std::uint64_t most = 0;
    if (found != cameras_.end())
        for (const auto& [format, output] : found->second.outputs) most = std::max(most, output->miss(frames, reason));
    return most;
}

void LocalFrameBus::publish(const frame::FrameSet& set, const std::shared_ptr<DeliveryLatch>& latch) {
    for (std::span<const frame::FrameRef> rest(set.frames); !rest.empty();) {
        const frame::FrameInfo& info = rest.front()->info();
        const auto next_camera = std::ranges::find_if(
            rest, [&](const frame::FrameRef& frame) { return frame->info().camera_id != info.camera_id; });
        const std::span<const frame::FrameRef> frames(rest.begin(), next_camera);
        rest = {next_camera, rest.end()};
        std::lock_guard lock(mutex_);
        const auto found = cameras_.find(info.camera_id);
        if (found == cameras_.end()) continue;
        // A frame drawn before a change of size belongs to outputs that have ended.
        if (info.size != found->second.stream.size) continue;
        for (const auto& [format, output] : found->second.outputs) {
            if (const frame::FrameRef* frame = frame_for(*output, frames)) output->offer(*frame, latch);
        }
    }
}

const frame::FrameRef* LocalFrameBus::frame_for(const Output& output, std::span<const frame::FrameRef> frames) {
    const frame::FrameRef* rgba = nullptr;
    const bool takes_numbers = output.format().number_bits != 0;
    for (const frame::FrameRef& frame : frames) {
        if (takes_numbers && frame->info().kind == frame::FrameKind::sensor &&
            frame->info().format == output.format().pixels)
            return &frame;
        if (takes_numbers || frame->info().kind != frame::FrameKind::color) continue;
        if (frame->info().format == output.source()) return &frame;
        if (frame->info().format == frame::PixelFormat::rgba8) rgba = &frame;
    }
    return rgba;  // null: drawn for others, before this output was there or for a reader of a higher rate
}

void LocalFrameBus::transcode_once(frame::FrameRef frame, const MediaFormat& format,
                                   std::function<void(Result<MediaUnit>)> done) {
    auto transcoder = Transcoder::create(format, options_.pool, timers_);
    if (!transcoder) return done(std::unexpected(transcoder.error()));
    const bool is_posted =
        pool_->post([frame = std::move(frame), transcoder = std::shared_ptr<Transcoder>(std::move(*transcoder)), done] {
            done(or_out_of_memory("encoding", [&] { return transcoder->transcode(frame); }));
        });
    if (!is_posted) done(error(ErrorKind::resource_exhausted, "too many pictures wait to be made; try again"));
}

void LocalFrameBus::fill_report(RigReport& report) const {
    report.stages.push_back({"convert", timers_->convert.summary()});
    report.stages.push_back({"encode", timers_->encode.summary()});
    std::lock_guard lock(mutex_);
    for (const auto& [id, camera] : cameras_) {
        const auto found = std::ranges::find(report.cameras, camera.stream.name, &CameraReport::name);
        if (found == report.cameras.end()) continue;
        for (const auto& [format, output] : camera.outputs) found->outputs.push_back(output->report());
    }
}

}  // namespace camrig::stream
