#include "core/engine/draw_desk.h"

#include <algorithm>
#include <tuple>

#include "core/base/clock.h"
#include "core/base/out_of_memory.h"
#include "core/engine/failing_pictures.h"

namespace camrig::engine {
namespace {

/// From here on views are drawn on the second lane.
constexpr int first_dear_class = 2;
/// So long a lane draws, some views at least, before that goes out and others have their turn: encoders begin while the
/// rest is drawn, and the first camera's reader need not wait for the last camera.
constexpr TimeNs turn_ns = ns_per_ms;
constexpr std::size_t turn_views = 2;  ///< one a core: fewer are drawn in pieces
/// An instant that begins so late tells that the machine is full. Then pictures a second matter more than the age of
/// the first, and a turn has more views: at the end of each the threads that draw wait for the slowest of them.
constexpr TimeNs late_ns = 10 * ns_per_ms;
constexpr TimeNs late_turn_ns = 40 * ns_per_ms;
constexpr std::size_t late_turn_views = 4;
/// What a view is taken to cost before one was drawn.
constexpr TimeNs first_view_ns = 8 * ns_per_ms;

TimeNs smoothed(TimeNs before_ns, TimeNs now_ns) {
    return std::max(TimeNs{1}, (3 * before_ns + now_ns) / 4);
}

}  // namespace

DrawnViews draw_views(render::Renderer& renderer, DueViews due, stream::StageTimer& timer) {
    DrawnViews drawn;
    const TimeNs start_ns = monotonic_now_ns();
    auto finished =
        or_out_of_memory("drawing", [&] { return draw_failing(renderer, due.snapshot, due.monotonic_ns, due.views); });
    if (finished) {
        drawn.frames = std::move(finished->set.frames);
        drawn.failures = std::move(finished->failures);
        drawn.cost_ns = std::move(finished->cost_ns);
    } else {
        for (const render::View& view : due.views) drawn.failures.push_back({view.camera, finished.error()});
    }
    timer.record(monotonic_now_ns() - start_ns);
    drawn.due = std::move(due);
    return drawn;
}

DrawDesk::DrawDesk(std::vector<std::unique_ptr<DrawLane>> lanes, std::shared_ptr<DrawnTasks> finished,
                   Callbacks callbacks)
    : finished_(std::move(finished)), callbacks_(std::move(callbacks)) {
    CHECK(lanes.size() == 1 || lanes.size() == 2);
    lanes_.reserve(lanes.size());
    for (auto& lane : lanes) {
        lanes_.emplace_back().lane = std::move(lane);
        lanes_.back().view_ns.fill(first_view_ns);
    }
}

TimeNs DrawDesk::Camera::known_ns() const {
    TimeNs known_ns = 0;
    for (const TimeNs ns : cpu_ns)
        if (ns > 0 && (known_ns == 0 || ns < known_ns)) known_ns = ns;
    return known_ns;
}

int DrawDesk::class_of(const GroupName& name) const {
    int dearest = 0;
    for (const auto& [id, camera] : cameras_) {
        if (camera.group != name) continue;
        const TimeNs known_ns = camera.known_ns();
        dearest = std::max(dearest, classes_.of(known_ns > 0 ? known_ns : camera.expected_ns));
        if (known_ns == 0 && !camera.is_plain) dearest = std::max(dearest, first_dear_class);
    }
    return dearest;
}

void DrawDesk::note_settings(const render::View& view) {
    Camera& camera = cameras_[view.camera];
    const ImageSize size = view.spec->size;
    const bool is_plain = lanes_.front().lane->is_plain(view);
    if (camera.size != size || camera.quality != view.quality || camera.is_plain != is_plain) {
        camera.cpu_ns.fill(0);
        camera.expected_ns = lanes_.front().lane->expected_cost_ns(view);
        camera.size = size;
        camera.quality = view.quality;
        camera.is_plain = is_plain;
    }
    // Its pictures come out in their order: what is pending stays where it is, and the next one follows it.
    if (camera.pending == 0) {
        const GroupName now = view.spec->group.empty() ? GroupName("", view.camera) : GroupName(view.spec->group, {});
        if (camera.group != now) leave_group(std::exchange(camera.group, now), view.camera);
    }
}

DrawDesk::Group& DrawDesk::assign(const render::View& view, bool may_be_dropped) {
    Camera& camera = cameras_.at(view.camera);
    Group& group = groups_[camera.group];
    // Who always has something to draw would never come to the class that its cost is of: a picture that waits goes.
    if (group.pending > 0 && may_be_dropped && class_of(camera.group) != group.cost_class)
        give_up_waiting(camera.group, group);
    if (group.pending == 0) choose_lane(camera.group, group);
    ++camera.pending;
    ++group.pending;
    ++pending_views_;
    return group;
}

void DrawDesk::choose_lane(const GroupName& name, Group& group) {
    group.cost_class = class_of(name);
    const bool is_plain = std::ranges::all_of(
        cameras_, [&](const auto& other) { return other.second.group != name || other.second.is_plain; });
    Lane* const lane = group.cost_class >= first_dear_class || !is_plain ? &lanes_.back() : &lanes_.front();
    if (group.lane != nullptr && group.lane != lane)
        for (const auto& [id, camera] : cameras_)
            if (camera.group == name) hand_over(*group.lane, id);
    group.lane = lane;
    group.requests_ns = lane->requests_ns;
    group.all_ns = lane->all_ns;
}

void DrawDesk::give_up_waiting(const GroupName& name, Group& group) {
    const auto is_drawn = [&](const auto& other) { return other.second.group == name && other.second.drawing > 0; };
    if (std::ranges::any_of(cameras_, is_drawn)) return;
    std::vector<DueViews> waiting;
    for (const auto& [id, camera] : cameras_)
        if (camera.group == name) group.lane->queue.remove(id, waiting);
    drop(waiting);
}

void DrawDesk::leave_group(const GroupName& name, CameraId camera) {
    const auto group = groups_.find(name);
    if (group == groups_.end()) return;
    if (group->second.lane != nullptr) forget(*group->second.lane, camera);
    const bool is_empty = std::ranges::none_of(
        cameras_, [&](const auto& other) { return other.first != camera && other.second.group == name; });
    if (is_empty) groups_.erase(group);
}

void DrawDesk::add(const DueViews& due) {
    for (const render::View& view : due.views) note_settings(view);
    // By lane and class, in the order of the views.
    std::map<std::pair<Lane*, int>, DueViews> parts;
    for (const render::View& view : due.views) {
        const Group& group = assign(view, due.may_be_dropped);
        DueViews& part = parts[{group.lane, group.cost_class}];
        part.views.push_back(view);
    }
    std::vector<DueViews> dropped;
    for (auto& [where, part] : parts) {
        part.snapshot = due.snapshot;
        part.monotonic_ns = due.monotonic_ns;
        part.may_be_dropped = due.may_be_dropped;
        where.first->queue.add(where.second, std::move(part), dropped);
    }
    drop(dropped);
}

stream::DropReason DrawDesk::reason_for(const Group& group) const {
    const TimeNs all_ns = group.lane->all_ns - group.all_ns, requests_ns = group.lane->requests_ns - group.requests_ns;
    if (2 * requests_ns > all_ns) return stream::DropReason::request;
    const auto rank = [](const Group& one) { return std::pair(one.lane, one.cost_class); };
    const bool is_dearer =
        std::ranges::any_of(groups_, [&](const auto& other) { return rank(other.second) < rank(group); });
    return is_dearer ? stream::DropReason::own_cost : stream::DropReason::overload;
}

void DrawDesk::drop(const std::vector<DueViews>& dropped) {
    for (const DueViews& due : dropped) {
        for (const render::View& view : due.views) {
            const stream::DropReason reason = reason_for(groups_.at(cameras_.at(view.camera).group));
            end_view(view);
            callbacks_.dropped(due, view, reason);
        }
    }
}

void DrawDesk::end_view(const render::View& view) {
    CHECK(pending_views_ > 0);
    --pending_views_;
    const auto found = cameras_.find(view.camera);
    if (found == cameras_.end()) return;  // deleted meanwhile
    --found->second.pending;
    Group& group = groups_.at(found->second.group);
    --group.pending;
    group.requests_ns = group.lane->requests_ns;
    group.all_ns = group.lane->all_ns;
}

void DrawDesk::take_finished() {
    for (auto& done : finished_->take_all()) done();
}

void DrawDesk::dispatch(TimeNs monotonic_ns) {
    for (Lane& lane : lanes_) dispatch(lane, monotonic_ns);
}

void DrawDesk::dispatch(Lane& lane, TimeNs monotonic_ns) {
    while (lane.tasks == 0) {
        const auto next = lane.queue.next();
        if (!next) return;
        if (*next == DrawQueue::requests)
            post_request(lane);
        else
            post_views(lane, *next, monotonic_ns);
    }
}

void DrawDesk::post_views(Lane& lane, int cost_class, TimeNs monotonic_ns) {
    const TimeNs view_ns = lane.view_ns[static_cast<std::size_t>(cost_class)];
    const bool is_dear = &lane != &lanes_.front();
    const bool is_late = monotonic_ns - lane.queue.due_since_ns(cost_class) > late_ns;
    const std::size_t least = is_dear ? 1 : is_late ? late_turn_views : turn_views;
    const TimeNs time_ns = is_late ? late_turn_ns : turn_ns;
    DueViews due = lane.queue.take(cost_class, std::max(least, static_cast<std::size_t>(time_ns / view_ns)));
    for (const render::View& view : due.views) ++cameras_.at(view.camera).drawing;
    ++lane.tasks;
    const auto drawn = std::make_shared<DrawnViews>();
    lane.lane->post(
        {.draw = [drawn, timer = timer_, due = std::move(due)](
                     render::Renderer& renderer) mutable { *drawn = draw_views(renderer, std::move(due), *timer); },
         .done = [this, &lane, cost_class,
                  drawn](TimeNs spent_ns) { finish_views(lane, cost_class, *drawn, spent_ns); }});
}

void DrawDesk::post_request(Lane& lane) {
    auto task = callbacks_.next_request();
    if (!task) return lane.queue.set_requests(false);
    ++lane.tasks;
    lane.lane->post(
        {.draw = std::move(task->draw), .done = [this, &lane, done = std::move(task->done)](TimeNs spent_ns) {
             --lane.tasks;
             charge(lane, DrawQueue::requests, spent_ns);
             done(spent_ns);
         }});
}

void DrawDesk::charge(Lane& lane, int one_class, TimeNs spent_ns) {
    lane.queue.charge(one_class, spent_ns);
    lane.all_ns += spent_ns;
    if (one_class == DrawQueue::requests) lane.requests_ns += spent_ns;
}

void DrawDesk::finish_views(Lane& lane, int cost_class, DrawnViews& drawn, TimeNs spent_ns) {
    --lane.tasks;
    charge(lane, cost_class, spent_ns);
    TimeNs& view_ns = lane.view_ns[static_cast<std::size_t>(cost_class)];
    view_ns = smoothed(view_ns, spent_ns / static_cast<TimeNs>(drawn.due.views.size()));
    for (std::size_t i = 0; i < drawn.due.views.size(); ++i) {
        const render::View& view = drawn.due.views[i];
        end_view(view);
        const auto found = cameras_.find(view.camera);
        if (found == cameras_.end()) continue;  // deleted meanwhile
        Camera& camera = found->second;
        --camera.drawing;
        if (!drawn.cost_ns.empty() && drawn.cost_ns[i] != not_drawn_ns)
            camera.cpu_ns[camera.next++ % camera.cpu_ns.size()] = std::max(TimeNs{1}, drawn.cost_ns[i]);
    }
    costs_.clear();
    for (const auto& [id, camera] : cameras_)
        if (const TimeNs known_ns = camera.known_ns(); known_ns > 0) costs_.push_back(known_ns);
    classes_.divide(costs_);
    // Now and not with its next view: until then what is kept of it may have come to the other lane.
    for (const render::View& view : drawn.due.views) {
        const auto found = cameras_.find(view.camera);
        if (found == cameras_.end()) continue;
        if (Group& group = groups_.at(found->second.group); group.pending == 0) choose_lane(found->second.group, group);
    }
    callbacks_.drawn(drawn);
}

void DrawDesk::finish() {
    for (take_finished(); !is_idle(); take_finished()) {
        dispatch(monotonic_now_ns());
        if (const auto done = finished_->wait()) (*done)();
    }
}

void DrawDesk::forget(CameraId camera) {
    std::vector<DueViews> waiting;
    for (Lane& lane : lanes_) {
        lane.queue.remove(camera, waiting);
        forget(lane, camera);
    }
    pending_views_ -= waiting.size();  // each is of one instant
    const auto found = cameras_.find(camera);
    if (found == cameras_.end()) return;
    if (const auto group = groups_.find(found->second.group); group != groups_.end())
        group->second.pending -= found->second.pending;
    const GroupName name = found->second.group;
    cameras_.erase(found);
    leave_group(name, camera);
}

void DrawDesk::forget(Lane& lane, CameraId camera) {
    lane.lane->post({.draw = [camera](render::Renderer& renderer) { renderer.forget(camera); }, .done = [](TimeNs) {}});
}

void DrawDesk::hand_over(Lane& lane, CameraId camera) {
    lane.lane->post(
        {.draw = [camera](render::Renderer& renderer) { renderer.hand_over(camera); }, .done = [](TimeNs) {}});
}

void DrawDesk::begin_world(const world::SnapshotRef& snapshot) {
    for (Lane& lane : lanes_)
        lane.lane->post(
            {.draw = [snapshot](render::Renderer& renderer) { std::ignore = renderer.draw(snapshot, 0, {}); },
             .done = [](TimeNs) {}});
}

render::RenderCounters DrawDesk::counters() const {
    render::RenderCounters sum;
    for (const Lane& lane : lanes_) sum += lane.lane->counters();
    return sum;
}

}  // namespace camrig::engine
