#include "core/engine/requests.h"

#include <algorithm>
#include <array>

#include "core/base/clock.h"
#include "core/base/out_of_memory.h"
#include "core/render/view_frames.h"
#include "core/render/view_motion.h"
#include "core/truth/make_truth.h"

namespace camrig::engine {
namespace {

constexpr std::size_t max_waiting = 256;
constexpr TimeNs frame_timeout_ns = 10 * ns_per_s;
/// On a shared lane a request leaves readers this many times as long before the next one.
constexpr TimeNs readers_share = 3;
constexpr TimeNs most_readers_turn_ns = ns_per_s;
/// What takes longer was the first of its kind: others are not expected to.
constexpr TimeNs most_expected_ns = 100 * ns_per_ms;

Error not_drawn(const std::string& camera) {
    return {ErrorKind::unavailable, "camera " + camera + ": this picture could not be drawn"};
}

render::View only(render::View view, frame::FrameKind kind) {
    std::ranges::fill(view.kinds, false);
    view.kinds[index_of(kind)] = true;
    return view;
}

using TruthMade = std::shared_ptr<truth::TruthOfFrame>;

Result<TruthMade> truth_of(render::Renderer& renderer, const DueViews& due,
                           const std::optional<truth::GroundGrid>& ground, truth::StandingObjects& standing,
                           stream::StageTimer& draw_time) {
    const render::View& view = due.views.front();
    const auto draw = [&](render::View one) -> Result<std::vector<frame::FrameRef>> {
        DrawnViews drawn = draw_views(renderer, {due.snapshot, due.monotonic_ns, {std::move(one)}, false}, draw_time);
        if (!drawn.failures.empty()) return std::unexpected(drawn.failures.front().error);
        return std::move(drawn.frames);
    };
    render::View scene = only(view, frame::FrameKind::instance);
    render::View alone = scene;
    scene.kinds[index_of(frame::FrameKind::depth)] = true;
    auto frames = draw(std::move(scene));
    if (!frames) return std::unexpected(frames.error());
    truth::TruthPictures pictures;
    for (const frame::FrameRef& frame : *frames)
        (frame->info().kind == frame::FrameKind::depth ? pictures.depth : pictures.instance) = frame;
    if (!pictures.depth || !pictures.instance) return std::unexpected(not_drawn(*view.name));
    const auto draw_alone = [&](std::span<const ObjectId> objects) -> Result<frame::FrameRef> {
        alone.only_objects.assign(objects.begin(), objects.end());
        auto one = draw(alone);
        if (!one) return std::unexpected(one.error());
        if (one->empty()) return std::unexpected(not_drawn(*view.name));
        return one->front();
    };
    const auto find_silhouettes =
        [&](std::span<const ObjectId> objects,
            std::span<const truth::PixelBox> reaches) -> Result<std::vector<frame::Silhouette>> {
        if (auto found = renderer.silhouettes(due.snapshot, view, objects)) return std::move(*found);
        return truth::silhouettes_from(draw_alone)(objects, reaches);
    };
    // While a sensor counted things moved: places are those of the middle row, which is drawn from the past.
    const auto exposure = render::exposure_of(view, *due.snapshot);
    if (!exposure) return std::unexpected(exposure.error());
    const auto motion = *exposure ? render::motion_of(view, (*exposure)->times) : std::nullopt;
    world::CameraPast::Moment shown{due.snapshot,
                                    {.pose = view.pose,
                                     .believed_pose = view.believed_pose,
                                     .intrinsics = view.spec->intrinsics,
                                     .head = view.head,
                                     .clock = {}}};
    std::optional<truth::RowsInTime> rows;
    if (motion) {
        shown = view.past->at(motion->times.middle_ns());
        if (motion->times.row_ns > 0)
            rows = truth::RowsInTime{view.past, motion->times.middle_ns(0), motion->times.row_ns};
    }
    auto truth = make_truth({.name = view.name,
                             .spec = render::view_at(view, shown.state).spec,
                             .pose = shown.state.pose,
                             .rows = std::move(rows),
                             .believed_pose = shown.state.believed_pose,
                             .head = shown.state.head,
                             .clock = pictures.instance->info().clock,
                             .sensor = pictures.instance->info().sensor,
                             .faults = view.faults,
                             .film = view.film,
                             .sequence = view.sequence,
                             .monotonic_ns = due.monotonic_ns},
                            *shown.snapshot, pictures, find_silhouettes, &standing);
    if (!truth) return at("camera " + *view.name, truth.error());
    truth->world_ns = due.snapshot->world_ns;
    if (ground) truth->ground = truth::seen_ground(*ground, *truth->spec, shown.state.pose, *pictures.depth);
    return std::make_shared<truth::TruthOfFrame>(std::move(*truth));
}

/// nullopt: it was drawn, or nobody read, or its turn is still to come.
std::optional<std::string_view> reason_not_drawn(const CameraEntry& camera, TimeNs world_ns) {
    const auto found = std::ranges::find(camera.not_drawn, world_ns, [](const auto& one) { return one.first; });
    if (found == camera.not_drawn.end()) return std::nullopt;
    return stream::drop_reason_names[static_cast<std::size_t>(found->second)];
}

}  // namespace

Requests::~Requests() {
    const Error why{ErrorKind::unavailable, "the rig shuts down"};
    for (const Waiter& waiter : waiting_) waiter.fail(why);
    for (const Waiter& waiter : drawing_) waiter.fail(why);
}

void Requests::Waiter::fail(const Error& why) const {
    if (got_picture)
        got_picture(std::unexpected(why));
    else
        got_truth(std::unexpected(why));
}

void Requests::fetch(stream::FetchRequest request, std::function<void(Result<stream::MediaUnit>)> done) {
    wait({.name = request.camera,
          .min_ns = request.min_ns,
          .picture = std::move(request),
          .got_picture = std::move(done),
          .got_truth = {}});
}

void Requests::get_truth(Request<GetTruth>& request) {
    stream::FetchRequest held;
    held.instant = request.command.instant;
    wait({.name = request.command.camera,
          .min_ns = request.command.min_ns,
          .picture = std::move(held),
          .ground = request.command.ground,
          .got_picture = {},
          .got_truth = std::move(request.done)});
}

void Requests::wait(Waiter waiter) {
    const auto found = rig_.cameras.find(waiter.name);
    if (!found) return waiter.fail(found.error());
    CameraEntry& entry = **found;
    waiter.camera = entry.id;
    if (waiter.got_picture && waiter.picture.kind == frame::FrameKind::sensor && !entry.spec().sensor)
        return waiter.fail({ErrorKind::invalid_argument,
                            "camera " + waiter.name + " has no sensor: set its field `sensor`, or ask for kind color"});
    // Without a wish of its own a read shows what the camera's last command did.
    if (waiter.min_ns == 0) {
        cameras_.show_waiting_change(entry);
        waiter.min_ns = entry.applied_ns;
    }
    const TimeNs now_ns = monotonic_now_ns();
    // Of a slow camera the next frame may take longer than that.
    waiter.timeout_ns =
        std::max(frame_timeout_ns, 2 * rig_.schedule.stride(entry.id) * entry.spec().rate.time_of_frame(1));
    waiter.deadline_ns = now_ns + waiter.timeout_ns;
    if (answer(waiter, now_ns)) return;
    if (waiting_.size() >= max_waiting)
        return waiter.fail({ErrorKind::resource_exhausted,
                            std::to_string(max_waiting) + " requests wait for a picture or truth; send slower"});
    is_ready_ = is_ready_ || is_to_be_drawn(waiter, entry);
    waiting_.push_back(std::move(waiter));
}

bool Requests::is_to_be_drawn(const Waiter& waiter, const CameraEntry& entry) const {
    if (!is_there(waiter, entry)) return false;
    // A running camera's picture is on its way: it will do.
    return !waiter.wants_color() || !rig_.drawing->is_pending(entry.id);
}

void Requests::add_awaited(const CameraEntry& entry, TimeNs world_ns, frame::PixelFormats& formats) const {
    for (const Waiter& waiter : waiting_) {
        if (waiter.wants_color() && waiter.min_ns <= world_ns && waiter.camera == entry.id)
            formats.add(source_format(waiter.picture.format, entry.spec().size));
    }
}

TimeNs Requests::next_turn_ns(TimeNs monotonic_ns) const {
    if (!rig_.clock.running() || !rig_.drawing->has_one_lane()) return 0;
    TimeNs due_ns = max_time_ns;
    for (const auto& [id, entry] : rig_.cameras.all())
        if (rig_.bus.reader_count(id) > 0) due_ns = std::min(due_ns, rig_.schedule.next_due_ns(id));
    if (due_ns == max_time_ns || monotonic_ns + cost_ns_ <= rig_.clock.monotonic_at(due_ns)) return 0;
    return from_ns_;
}

TimeNs Requests::wake_time_ns() const {
    TimeNs wake_ns = max_time_ns;
    for (const Waiter& waiter : waiting_) wake_ns = std::min(wake_ns, waiter.deadline_ns);
    // What a lane is offered it takes when it has done what it is at, and says so.
    if (is_ready_ && !is_offered_ && drawing_.empty()) wake_ns = std::min(wake_ns, next_turn_ns(monotonic_now_ns()));
    return wake_ns;
}

const frame::FrameRef* Requests::drawn_color(const CameraEntry& entry, std::span<const frame::FrameRef> frames,
                                             const stream::MediaFormat& format) const {
    if (frames.empty()) return nullptr;
    const render::View view = std::move(rig_.picture_of(entry).views.front());
    const frame::PixelFormats made = rig_.made_of(view, {source_format(format, view.spec->size)});
    // Anything but a JPEG is the same bytes made of rgba8.
    const bool takes_rgba = format.codec != codec::Codec::jpeg;
    for (const frame::FrameRef& frame : frames) {
        const frame::PixelFormat pixels = frame->info().format;
        if (made.contains(pixels) || (takes_rgba && pixels == frame::PixelFormat::rgba8)) return &frame;
    }
    return nullptr;
}

void Requests::give_drawn(const Waiter& waiter, const frame::FrameRef& drawn) const {
    if (waiter.picture.admit)
        if (auto admitted = waiter.picture.admit(drawn->info().size); !admitted) return waiter.fail(admitted.error());
    rig_.bus.transcode_once(drawn, waiter.picture.format, waiter.got_picture);
}

bool Requests::answer(const Waiter& waiter, TimeNs monotonic_ns) const {
    const CameraEntry* entry = rig_.cameras.find_id(waiter.camera);
    if (entry == nullptr) {
        waiter.fail({ErrorKind::not_found, "camera " + waiter.name + " was deleted"});
        return true;
    }
    const bool there = is_there(waiter, *entry);
    if (there && waiter.wants_color()) {
        if (const frame::FrameRef* drawn =
                drawn_color(*entry, entry->latest.delivered().colors, waiter.picture.format)) {
            give_drawn(waiter, *drawn);
            return true;
        }
    }
    if (monotonic_ns < waiter.deadline_ns) return false;
    if (there) {
        waiter.fail({ErrorKind::resource_exhausted,
                     "so many pictures are asked for that camera " + waiter.name + "'s was not drawn within " +
                         std::to_string(waiter.timeout_ns / ns_per_s) + " s; send slower, or read it as a stream"});
    } else {
        waiter.fail({ErrorKind::unavailable,
                     "camera " + waiter.name + " has no frame at or after min_ns " + std::to_string(waiter.min_ns) +
                         " yet; its latest shows world time " + std::to_string(entry->latest.state.world_ns) +
                         (rig_.clock.running() ? " ns" : " ns and the world stands still: step or resume it")});
    }
    return true;
}

void Requests::turn(TimeNs monotonic_ns) {
    turn_ns_ = monotonic_ns;
    is_ready_ = false;
    for (auto it = waiting_.begin(); it != waiting_.end();) {
        const Waiter& waiter = *it;
        if (answer(waiter, monotonic_ns)) {
            it = waiting_.erase(it);
            continue;
        }
        is_ready_ = is_ready_ || is_to_be_drawn(waiter, rig_.cameras.at(waiter.camera));
        ++it;
    }
    is_offered_ = is_ready_ && next_turn_ns(monotonic_ns) <= monotonic_ns;
    rig_.drawing->set_requests(is_offered_);
}

void Requests::colors_drawn(const CameraEntry& entry, std::span<const frame::FrameRef> frames) {
    if (frames.empty()) return;
    for (auto it = waiting_.begin(); it != waiting_.end();) {
        const Waiter& waiter = *it;
        const bool wants =
            waiter.camera == entry.id && waiter.wants_color() && waiter.min_ns <= frames.front()->info().world_ns;
        const frame::FrameRef* drawn = wants ? drawn_color(entry, frames, waiter.picture.format) : nullptr;
        if (drawn == nullptr) {
            ++it;
            continue;
        }
        give_drawn(waiter, *drawn);
        it = waiting_.erase(it);
    }
}

std::optional<DrawTask> Requests::next() {
    if (next_turn_ns(turn_ns_) > turn_ns_) return std::nullopt;
    for (auto it = waiting_.begin(); it != waiting_.end();) {
        const auto waiter = it++;
        CameraEntry* entry = rig_.cameras.find_id(waiter->camera);
        if (entry == nullptr || !is_to_be_drawn(*waiter, *entry)) continue;
        LatestDue held;
        if (const HeldInstant* const instant = waiter->instant()) {
            if (instant->scene != rig_.scene) {
                waiter->fail(
                    {ErrorKind::unavailable, "another world was loaded since that instant; ask for a new one"});
                waiting_.erase(waiter);
                continue;
            }
            held = rig_.cameras.at_instant(*entry, *instant);
        }
        const LatestDue& latest = waiter->instant() ? held : entry->latest;
        DueViews due{latest.snapshot, latest.monotonic_ns, {rig_.view_of(*entry, latest)}};
        if (waiter->wants_color()) due = rig_.picture_of(*entry);
        due.may_be_dropped = false;
        if (waiter->got_picture && waiter->picture.kind == frame::FrameKind::flow) {
            if (auto ahead = rig_.look_ahead(*entry, latest, due.views.front()); !ahead) {
                waiter->fail(ahead.error());
                waiting_.erase(waiter);
                continue;
            }
        }
        if (waiter->picture.admit) {
            if (auto admitted = waiter->picture.admit(latest.spec->size); !admitted) {
                waiter->fail(admitted.error());
                waiting_.erase(waiter);
                continue;
            }
        }
        is_offered_ = false;
        drawing_.splice(drawing_.end(), waiting_, waiter);
        return waiter->got_truth ? draw_truth(waiter, *entry, std::move(due)) : draw_picture(waiter, std::move(due));
    }
    return std::nullopt;
}

DrawTask Requests::draw_picture(Waiters::iterator waiter, DueViews due) {
    render::View& view = due.views.front();
    view = only(view, waiter->picture.kind);
    if (waiter->draws_color())
        view.color_formats = rig_.made_of(view, {source_format(waiter->picture.format, view.spec->size)});
    const auto drawn = std::make_shared<DrawnViews>();
    return {.draw = [drawn, due = std::move(due), timer = rig_.drawing->timer()](
                        render::Renderer& renderer) mutable { *drawn = draw_views(renderer, std::move(due), *timer); },
            .done =
                [this, waiter, drawn](TimeNs spent_ns) {
                    if (drawn->frames.empty()) {
                        const Error why =
                            drawn->failures.empty() ? not_drawn(waiter->name) : drawn->failures.front().error;
                        rig_.note_failure(waiter->name, why);
                        waiter->fail(why);
                    } else {
                        const frame::FrameRef& frame = drawn->frames.front();
                        CameraEntry* entry = rig_.cameras.find_id(waiter->camera);
                        const render::View& shown = drawn->due.views.front();
                        if (waiter->wants_color() && entry != nullptr)
                            rig_.cameras.keep_colors(*entry, shown, drawn->frames);
                        rig_.bus.transcode_once(frame, waiter->picture.format, std::move(waiter->got_picture));
                    }
                    end_drawing(waiter, spent_ns);
                }};
}

DrawTask Requests::draw_truth(Waiters::iterator waiter, const CameraEntry& entry, DueViews due) {
    const auto made = std::make_shared<Result<TruthMade>>();
    return {.draw =
                [made, standing = entry.standing, ground = waiter->ground, due = std::move(due),
                 draw_time = rig_.drawing->timer()](render::Renderer& renderer) {
                    *made = or_out_of_memory("finding the truth",
                                             [&] { return truth_of(renderer, due, ground, *standing, *draw_time); });
                },
            .done =
                [this, waiter, made](TimeNs spent_ns) {
                    const CameraEntry* const camera = rig_.cameras.find_id(waiter->camera);
                    if (*made && camera && !waiter->instant())
                        (**made)->not_drawn = reason_not_drawn(*camera, (**made)->world_ns);
                    waiter->got_truth(std::move(*made));
                    truth_time_.record(spent_ns);
                    end_drawing(waiter, spent_ns);
                }};
}

void Requests::end_drawing(Waiters::iterator waiter, TimeNs spent_ns) {
    drawing_.erase(waiter);
    cost_ns_ = (cost_ns_ + std::min(spent_ns, most_expected_ns)) / 2;
    from_ns_ = turn_ns_ + spent_ns + std::min(readers_share * spent_ns, most_readers_turn_ns);
}

}  // namespace camrig::engine
