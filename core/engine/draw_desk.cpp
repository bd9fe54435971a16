#include "core/engine/draw_desk.h"

#include <algorithm>
#include <tuple>

#include "core/base/clock.h"

namespace camrig {
namespace {

/// The least cost of each class, CPU time of a view: what differs less than this is drawn and dropped together.
constexpr std::array<TimeNs, DrawQueue::cost_classes> class_from_ns = {0, 4 * ns_per_ms, 16 * ns_per_ms, 64 * ns_per_ms,
                                                                       256 * ns_per_ms};
/// From here on views are drawn on the second lane.
constexpr int first_dear_class = 2;
/// A class is left only when the cost is so much beyond its bounds: costs vary.
constexpr double class_margin = 1.25;
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

int class_of(TimeNs cpu_ns) {
    int cost_class = 0;
    while (cost_class + 1 < DrawQueue::cost_classes &&
           cpu_ns >= class_from_ns[static_cast<std::size_t>(cost_class) + 1])
        ++cost_class;
    return cost_class;
}

/// The class of a camera that was in `present`.
int class_of(TimeNs cpu_ns, int present) {
    const auto nearer = static_cast<double>(cpu_ns) * (class_of(cpu_ns) > present ? 1.0 / class_margin : class_margin);
    return class_of(static_cast<TimeNs>(nearer)) == present ? present : class_of(cpu_ns);
}

TimeNs smoothed(TimeNs before_ns, TimeNs now_ns) {
    return std::max(TimeNs{1}, (3 * before_ns + now_ns) / 4);
}

}  // namespace

DrawnViews draw_views(Renderer& renderer, DueViews due, StageTimer& timer) {
    DrawnViews drawn;
    const TimeNs start_ns = monotonic_now_ns();
    if (auto finished = renderer.draw(due.snapshot, due.monotonic_ns, due.views)) {
        drawn.frames = std::move(finished->set.frames);
        drawn.failures = std::move(finished->failures);
        drawn.cost_ns = std::move(finished->cost_ns);
    } else {
        for (const View& view : due.views) drawn.failures.push_back({view.camera, finished.error()});
    }
    drawn.wall_ns = monotonic_now_ns() - start_ns;
    timer.record(drawn.wall_ns);
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

DrawDesk::Cost& DrawDesk::place(const View& view) {
    Cost& cost = costs_[view.camera];
    const ImageSize size = view.spec->size;
    const bool is_plain = lanes_.front().lane->is_plain(view);
    // Its pictures come out in their order: what is at work stays where it is, and the next one follows it.
    if (cost.at_work > 0) return cost;
    if (cost.size != size || cost.quality != view.quality || cost.is_plain != is_plain) {
        cost.cpu_ns.fill(0);
        cost.size = size;
        cost.quality = view.quality;
        cost.is_plain = is_plain;
    }
    if (const TimeNs cpu_ns = std::ranges::min(cost.cpu_ns); cpu_ns > 0)
        cost.cost_class = class_of(cpu_ns, cost.cost_class);
    else
        cost.cost_class = is_plain ? 0 : first_dear_class;
    const bool is_dear = cost.cost_class >= first_dear_class || !is_plain;
    Lane* const lane = is_dear ? &lanes_.back() : &lanes_.front();
    // What the other one kept for it is of no use any more.
    if (cost.lane != nullptr && cost.lane != lane) forget(*cost.lane, view.camera);
    cost.lane = lane;
    cost.requests_ns = cost.lane->requests_ns;
    cost.all_ns = cost.lane->all_ns;
    return cost;
}

void DrawDesk::add(const DueViews& due) {
    // By lane and class, in the order of the views.
    std::map<std::pair<Lane*, int>, DueViews> parts;
    for (const View& view : due.views) {
        Cost& cost = place(view);
        ++cost.at_work;
        ++views_at_work_;
        DueViews& part = parts[{cost.lane, cost.cost_class}];
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

DropReason DrawDesk::reason_for(const Cost& cost) const {
    const TimeNs all_ns = cost.lane->all_ns - cost.all_ns, requests_ns = cost.lane->requests_ns - cost.requests_ns;
    if (2 * requests_ns > all_ns) return DropReason::request;
    const auto rank = [](const Cost& one) { return std::pair(one.lane, one.cost_class); };
    const bool is_dearer = std::ranges::any_of(
        costs_, [&](const auto& other) { return other.second.lane != nullptr && rank(other.second) < rank(cost); });
    return is_dearer ? DropReason::own_cost : DropReason::overload;
}

void DrawDesk::drop(const std::vector<DueViews>& dropped) {
    for (const DueViews& due : dropped) {
        for (const View& view : due.views) {
            const DropReason reason = reason_for(costs_.at(view.camera));
            end_work(view);
            callbacks_.dropped(due, view, reason);
        }
    }
}

void DrawDesk::end_work(const View& view) {
    CHECK(views_at_work_ > 0);
    --views_at_work_;
    const auto found = costs_.find(view.camera);
    if (found == costs_.end()) return;  // deleted meanwhile
    Cost& cost = found->second;
    --cost.at_work;
    cost.requests_ns = cost.lane->requests_ns;
    cost.all_ns = cost.lane->all_ns;
}

void DrawDesk::hear() {
    for (auto& done : finished_->take()) done();
}

void DrawDesk::hand_out(TimeNs monotonic_ns) {
    for (Lane& lane : lanes_) hand_out(lane, monotonic_ns);
}

void DrawDesk::hand_out(Lane& lane, TimeNs monotonic_ns) {
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
    ++lane.tasks;
    const auto drawn = std::make_shared<DrawnViews>();
    lane.lane->post({.draw = [drawn, timer = timer_, due = std::move(due)](
                                 Renderer& renderer) mutable { *drawn = draw_views(renderer, std::move(due), *timer); },
                     .done = [this, &lane, cost_class, drawn] { hear_of(lane, cost_class, *drawn); }});
}

void DrawDesk::post_request(Lane& lane) {
    auto task = callbacks_.next_request();
    if (!task) return lane.queue.set_requests(false);
    ++lane.tasks;
    const auto wall_ns = std::make_shared<TimeNs>();
    lane.lane->post({.draw =
                         [draw = std::move(task->draw), wall_ns](Renderer& renderer) {
                             const TimeNs start_ns = monotonic_now_ns();
                             draw(renderer);
                             *wall_ns = monotonic_now_ns() - start_ns;
                         },
                     .done =
                         [this, &lane, done = std::move(task->done), wall_ns] {
                             --lane.tasks;
                             spend(lane, DrawQueue::requests, *wall_ns);
                             done();
                         }});
}

void DrawDesk::spend(Lane& lane, int one_class, TimeNs wall_ns) {
    lane.queue.charge(one_class, wall_ns);
    lane.all_ns += wall_ns;
    if (one_class == DrawQueue::requests) lane.requests_ns += wall_ns;
}

void DrawDesk::hear_of(Lane& lane, int cost_class, DrawnViews& drawn) {
    --lane.tasks;
    spend(lane, cost_class, drawn.wall_ns);
    TimeNs& view_ns = lane.view_ns[static_cast<std::size_t>(cost_class)];
    view_ns = smoothed(view_ns, drawn.wall_ns / static_cast<TimeNs>(drawn.due.views.size()));
    for (std::size_t i = 0; i < drawn.due.views.size(); ++i) {
        const View& view = drawn.due.views[i];
        end_work(view);
        const auto found = costs_.find(view.camera);
        if (found == costs_.end() || drawn.cost_ns.empty()) continue;
        Cost& cost = found->second;
        cost.cpu_ns[cost.next++ % cost.cpu_ns.size()] = std::max(TimeNs{1}, drawn.cost_ns[i]);
    }
    callbacks_.drawn(drawn);
}

void DrawDesk::finish() {
    for (hear(); !is_idle(); hear()) {
        hand_out(monotonic_now_ns());
        finished_->wait();
    }
}

void DrawDesk::discard() {
    std::vector<DueViews> dropped;
    for (Lane& lane : lanes_) lane.queue.clear(dropped);
    drop(dropped);
}

void DrawDesk::forget(CameraId camera) {
    for (Lane& lane : lanes_) {
        views_at_work_ -= lane.queue.remove(camera);
        forget(lane, camera);
    }
    costs_.erase(camera);
}

void DrawDesk::forget(Lane& lane, CameraId camera) {
    lane.lane->post({.draw = [camera](Renderer& renderer) { renderer.forget(camera); }, .done = [] {}});
}

void DrawDesk::begin_world(const SnapshotRef& snapshot) {
    for (Lane& lane : lanes_)
        lane.lane->post(
            {.draw = [snapshot](Renderer& renderer) { std::ignore = renderer.draw(snapshot, 0, {}); }, .done = [] {}});
}

RenderCounters DrawDesk::counters() const {
    RenderCounters sum;
    for (const Lane& lane : lanes_) sum += lane.lane->counters();
    return sum;
}

}  // namespace camrig
