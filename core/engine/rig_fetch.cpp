#include <algorithm>
#include <array>

#include "core/base/clock.h"
#include "core/engine/rig.h"
#include "core/truth/make_truth.h"

// Pictures and truth on request: of a camera's latest due frame, drawn now if nobody was watching, from the snapshot of
// its instant.
namespace camrig {
namespace {

constexpr std::size_t max_waiting = 256;
constexpr TimeNs frame_timeout_ns = 10 * ns_per_s;
/// A request that takes from the time of readers' pictures leaves them this many times as long before the next one.
constexpr TimeNs readers_share = 3;
constexpr TimeNs most_readers_turn_ns = ns_per_s;
/// What takes longer was the first of its kind: others are not expected to.
constexpr TimeNs most_expected_ns = 100 * ns_per_ms;

Error not_drawn(const CameraEntry& entry) {
    return {ErrorKind::unavailable,
            "camera " + *entry.name + ": this picture could not be drawn; the log of the rig says why"};
}

}  // namespace

void Rig::wait_for_frame(Waiter waiter) {
    auto found = cameras_.find(waiter.camera);
    if (!found) return waiter.done(std::move(found));
    const bool is_there = (*found)->latest.world_ns >= waiter.min_ns;
    if (is_there && !is_to_be_drawn(waiter, **found)) return waiter.done(std::move(found));
    if (waiting_.size() >= max_waiting)
        return waiter.done(error(ErrorKind::resource_exhausted,
                                 std::to_string(max_waiting) + " requests wait for a picture or truth; send slower"));
    is_request_ready_ = is_request_ready_ || is_there;
    waiter.deadline_ns = monotonic_now_ns() + frame_timeout_ns;
    waiting_.push_back(std::move(waiter));
}

void Rig::add_awaited(const CameraEntry& entry, TimeNs world_ns, PixelFormats& formats) const {
    for (const Waiter& waiter : waiting_) {
        if (waiter.color && waiter.min_ns <= world_ns && waiter.camera == *entry.name)
            formats.add(source_format(*waiter.color, entry.spec->size));
    }
}

PixelFormats Rig::made_of(const View& view, PixelFormats wanted) const {
    PixelFormats made;
    for (const PixelFormat format : color_formats) {
        if (wanted.contains(format)) made.add(renderer_->makes(format, view) ? format : PixelFormat::rgba8);
    }
    return made;
}

TimeNs Rig::next_request_ns(TimeNs monotonic_ns) const {
    if (!clock_.running()) return 0;
    TimeNs due_ns = max_time_ns;
    for (const auto& [id, entry] : cameras_.all())
        if (bus_.reader_count(id) > 0) due_ns = std::min(due_ns, schedule_.next_due_ns(id));
    if (due_ns == max_time_ns || monotonic_ns + request_cost_ns_ <= clock_.monotonic_at(due_ns)) return 0;
    return requests_from_ns_;
}

void Rig::answer_waiting(TimeNs monotonic_ns) {
    is_request_ready_ = false;
    if (waiting_.empty()) return;
    bool may_draw = next_request_ns(monotonic_ns) <= monotonic_ns;
    for (auto it = waiting_.begin(); it != waiting_.end();) {
        auto found = cameras_.find(it->camera);
        const bool is_there = found && (*found)->latest.world_ns >= it->min_ns;
        const bool draws = is_there && is_to_be_drawn(*it, **found);
        if (found && monotonic_ns < it->deadline_ns && (!is_there || (draws && !may_draw))) {
            is_request_ready_ = is_request_ready_ || draws;
            ++it;
            continue;
        }
        const Waiter waiter = std::move(*it);
        it = waiting_.erase(it);
        if (draws && !may_draw) {
            waiter.done(error(ErrorKind::resource_exhausted, "so many pictures are asked for that camera " +
                                                                 waiter.camera + "'s was not drawn within " +
                                                                 std::to_string(frame_timeout_ns / ns_per_s) +
                                                                 " s; send slower, or read it as a stream"));
        } else if (is_there || !found) {
            const TimeNs start_ns = monotonic_now_ns();
            waiter.done(std::move(found));
            if (!draws) continue;
            may_draw = false;
            const TimeNs cost_ns = monotonic_now_ns() - start_ns;
            request_cost_ns_ = (request_cost_ns_ + std::min(cost_ns, most_expected_ns)) / 2;
            requests_from_ns_ = monotonic_ns + cost_ns + std::min(readers_share * cost_ns, most_readers_turn_ns);
        } else {
            waiter.done(error(ErrorKind::unavailable,
                              "camera " + waiter.camera + " has no frame at or after min_ns " +
                                  std::to_string(waiter.min_ns) + " yet; its latest shows world time " +
                                  std::to_string((*found)->latest.world_ns) +
                                  (clock_.running() ? " ns" : " ns and the world stands still: step or resume it")));
        }
    }
}

void Rig::fetch(FetchRequest request, std::function<void(Result<MediaUnit>)> done) {
    thread_.check();
    Waiter waiter{.camera = request.camera, .min_ns = request.min_ns, .color = {}, .done = {}};
    if (request.kind == FrameKind::color) waiter.color = request.format;
    waiter.done = [this, request = std::move(request), done = std::move(done)](Result<CameraEntry*> entry) {
        if (!entry) return done(std::unexpected(entry.error()));
        answer(**entry, request, done);
    };
    wait_for_frame(std::move(waiter));
}

const FrameRef* Rig::drawn_color(const CameraEntry& entry, const MediaFormat& format) const {
    const View view = view_of(entry, entry.latest);
    const PixelFormats made = made_of(view, {source_format(format, view.spec->size)});
    // Anything but a JPEG is the same bytes made of rgba8.
    const bool takes_rgba = format.codec != Codec::jpeg;
    for (const FrameRef& frame : entry.latest.colors) {
        const PixelFormat pixels = frame->info().format;
        if (made.contains(pixels) || (takes_rgba && pixels == PixelFormat::rgba8)) return &frame;
    }
    return nullptr;
}

void Rig::answer(CameraEntry& entry, const FetchRequest& request, std::function<void(Result<MediaUnit>)> done) {
    LatestDue& latest = entry.latest;
    View view = view_of(entry, latest);
    if (request.admit)
        if (auto admitted = request.admit(view.spec->size); !admitted) return done(std::unexpected(admitted.error()));
    std::ranges::fill(view.kinds, false);
    view.kinds[static_cast<std::size_t>(request.kind)] = true;
    if (request.kind == FrameKind::color) {
        if (const FrameRef* drawn = drawn_color(entry, request.format))
            return bus_.transcode_once(*drawn, request.format, std::move(done));
        view.color_formats = made_of(view, {source_format(request.format, view.spec->size)});
    }
    const FrameSet set = draw(latest.snapshot, latest.monotonic_ns, std::array{view});
    if (set.frames.empty()) return done(std::unexpected(not_drawn(entry)));
    const FrameRef& frame = set.frames.front();
    if (request.kind == FrameKind::color) latest.colors.push_back(frame);
    bus_.transcode_once(frame, request.format, std::move(done));
}

void Rig::get_truth(Request<GetTruth>& request) {
    wait_for_frame({.camera = request.command.camera,
                    .min_ns = request.command.min_ns,
                    .color = {},
                    .done = [this, done = std::move(request.done)](Result<CameraEntry*> entry) {
                        if (!entry) return done(std::unexpected(entry.error()));
                        const TimeNs start_ns = monotonic_now_ns();
                        auto truth = truth_of(**entry);
                        truth_.record(monotonic_now_ns() - start_ns);
                        done(std::move(truth));
                    }});
}

Result<TruthRef> Rig::truth_of(CameraEntry& entry) {
    const LatestDue& latest = entry.latest;
    View view = view_of(entry, latest);
    std::ranges::fill(view.kinds, false);
    view.kinds[static_cast<std::size_t>(FrameKind::instance)] = true;
    const auto draw_alone = [&](std::span<const ObjectId> objects) -> Result<FrameRef> {
        view.only_objects.assign(objects.begin(), objects.end());
        const FrameSet set = draw(latest.snapshot, latest.monotonic_ns, std::array{view});
        if (set.frames.empty()) return std::unexpected(not_drawn(entry));
        return set.frames.front();
    };
    View scene = view;
    scene.kinds[static_cast<std::size_t>(FrameKind::depth)] = true;
    const FrameSet set = draw(latest.snapshot, latest.monotonic_ns, std::array{scene});
    TruthPictures pictures;
    for (const FrameRef& frame : set.frames)
        (frame->info().kind == FrameKind::depth ? pictures.depth : pictures.instance) = frame;
    if (!pictures.depth || !pictures.instance) return std::unexpected(not_drawn(entry));
    auto truth = make_truth({.name = view.name,
                             .spec = view.spec,
                             .pose = view.pose,
                             .sequence = view.sequence,
                             .monotonic_ns = latest.monotonic_ns},
                            *latest.snapshot, pictures, draw_alone);
    if (!truth) return at("camera " + *entry.name, truth.error());
    return std::make_shared<const TruthOfFrame>(std::move(*truth));
}

}  // namespace camrig
