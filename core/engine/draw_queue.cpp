#include "core/engine/draw_queue.h"

#include <algorithm>
#include <iterator>
#include <set>

namespace camrig::engine {

void DrawQueue::begin_work(int one_class) {
    Class& one = classes_[static_cast<std::size_t>(one_class)];
    one.spent_ns = std::max(one.spent_ns, virtual_time_ns_);
}

void DrawQueue::add(int cost_class, DueViews due, std::vector<DueViews>& dropped) {
    if (due.views.empty()) return;
    if (!has_work(cost_class)) begin_work(cost_class);
    Class& one = classes_[static_cast<std::size_t>(cost_class)];
    one.due.push_back(std::move(due));
    drop_superseded(one, dropped);
}

// From the newest to the oldest: an instant goes when each of its cameras has a newer one.
void DrawQueue::drop_superseded(Class& one, std::vector<DueViews>& dropped) {
    std::set<CameraId> newer;
    for (auto at = one.due.end(); at != one.due.begin();) {
        --at;
        const bool is_superseded =
            std::ranges::all_of(at->views, [&](const render::View& view) { return newer.contains(view.camera); });
        for (const render::View& view : at->views) newer.insert(view.camera);
        const bool is_begun = one.is_begun && at == one.due.begin();
        if (!is_superseded || !at->may_be_dropped || is_begun) continue;
        dropped.push_back(std::move(*at));
        at = one.due.erase(at);
    }
}

void DrawQueue::set_requests(bool are_waiting) {
    if (are_waiting && !has_requests_) begin_work(requests);
    has_requests_ = are_waiting;
}

std::optional<int> DrawQueue::next() {
    std::optional<int> least;
    for (int i = 0; i < all_classes; ++i) {
        if (!has_work(i)) continue;
        if (!least ||
            classes_[static_cast<std::size_t>(i)].spent_ns < classes_[static_cast<std::size_t>(*least)].spent_ns)
            least = i;
    }
    if (least) virtual_time_ns_ = classes_[static_cast<std::size_t>(*least)].spent_ns;
    return least;
}

DueViews DrawQueue::take(int cost_class, std::size_t most) {
    Class& one = classes_[static_cast<std::size_t>(cost_class)];
    DueViews& first = one.due.front();
    if (!one.is_begun) one.cameras = first.views.size();
    const std::size_t count = std::min(most, first.views.size());
    one.is_begun = count < first.views.size();
    if (!one.is_begun) {
        DueViews all = std::move(first);
        one.due.pop_front();
        return all;
    }
    const auto end = first.views.begin() + static_cast<std::ptrdiff_t>(count);
    DueViews some{first.snapshot, first.monotonic_ns, {}, first.may_be_dropped};
    some.views.assign(std::make_move_iterator(first.views.begin()), std::make_move_iterator(end));
    first.views.erase(first.views.begin(), end);
    return some;
}

void DrawQueue::charge(int one_class, TimeNs spent_ns) {
    double cameras = 0;
    if (one_class == requests) {
        constexpr double share = 1.0 / 3.0;
        for (int i = 0; i < cost_classes; ++i)
            if (has_work(i)) cameras += share * static_cast<double>(classes_[static_cast<std::size_t>(i)].cameras);
    } else {
        cameras = static_cast<double>(classes_[static_cast<std::size_t>(one_class)].cameras);
    }
    classes_[static_cast<std::size_t>(one_class)].spent_ns += static_cast<double>(spent_ns) / std::max(1.0, cameras);
}

void DrawQueue::remove(CameraId camera, std::vector<DueViews>& removed) {
    for (Class& one : classes_) {
        for (auto at = one.due.begin(); at != one.due.end();) {
            const auto first = std::ranges::stable_partition(
                at->views, [&](const render::View& view) { return view.camera != camera; });
            if (!first.empty()) {
                DueViews& gone = removed.emplace_back(at->snapshot, at->monotonic_ns);
                gone.may_be_dropped = at->may_be_dropped;
                std::ranges::move(first, std::back_inserter(gone.views));
                at->views.erase(first.begin(), first.end());
            }
            if (!at->views.empty()) {
                ++at;
                continue;
            }
            if (at == one.due.begin()) one.is_begun = false;
            at = one.due.erase(at);
        }
    }
}

bool DrawQueue::empty() const {
    return std::ranges::all_of(classes_, [](const Class& one) { return one.due.empty(); });
}

}  // namespace camrig::engine
