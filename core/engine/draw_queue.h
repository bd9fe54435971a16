#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/engine/cost_classes.h"
#include "core/render/renderer.h"

namespace camrig::engine {

/// Pictures that are due at one instant.
struct DueViews {
    world::SnapshotRef snapshot;
    TimeNs monotonic_ns = 0;
    std::vector<render::View> views;
    bool may_be_dropped = true;  ///< when newer pictures of its cameras are due
};

/// The views that wait for one lane, and which of them it draws next. Pure arithmetic: no clock, no threads.
///
/// Cameras whose pictures cost alike are a class; its instants are drawn whole, from the oldest that is some camera's
/// newest, and all before it are dropped. So cameras of like cost drop the same instants, none starves, and what is
/// kept is at most an instant per camera.
///
/// Between classes drawing time is shared fairly, a share per camera: the class that had least of it per camera is next
/// (start-time fair queuing; Goyal, Vin, Cheng 1997). A class that had nothing to draw gets no credit for that time.
/// Pictures and truth on request are one more class, whose weight is a third of that of all cameras together.
class DrawQueue {
public:
    static constexpr int cost_classes = CostClasses::count;
    static constexpr int requests = cost_classes;
    static constexpr int all_classes = cost_classes + 1;

    /// Adds views of an instant. Views that they supersede go to `dropped`.
    void add(int cost_class, DueViews due, std::vector<DueViews>& dropped);
    /// Whether requests have something to draw.
    void set_requests(bool are_waiting);

    /// The class to draw next; nullopt: there is nothing to draw.
    std::optional<int> next();
    /// Removes and returns the next views of a cost class: of one instant, at most `most`. Not empty if any wait.
    DueViews take(int cost_class, std::size_t most);
    /// Adds drawing time to a class's account.
    void charge(int one_class, TimeNs spent_ns);

    /// CLOCK_MONOTONIC time of the instant of the views that take() would give. The class must have some.
    TimeNs due_since_ns(int cost_class) const {
        return classes_[static_cast<std::size_t>(cost_class)].due.front().monotonic_ns;
    }

    /// Removes the waiting views of a camera; they go to `removed`, each with its instant.
    void remove(CameraId camera, std::vector<DueViews>& removed);
    /// Whether no views wait. Requests do not count.
    bool empty() const;

private:
    struct Class {
        std::deque<DueViews> due;  ///< oldest first, each the newest of some camera; the first may be begun
        bool is_begun = false;
        std::size_t cameras = 1;  ///< of its last instant: the weight of the class
        double spent_ns = 0;      ///< drawing time for each of `cameras`: the start tag of what is drawn next
    };
    bool has_work(int one_class) const {
        return one_class == requests ? has_requests_ : !classes_[static_cast<std::size_t>(one_class)].due.empty();
    }
    /// A class has something to draw from now on.
    void begin_work(int one_class);
    void drop_superseded(Class& one, std::vector<DueViews>& dropped);

    std::array<Class, all_classes> classes_;
    bool has_requests_ = false;
    double virtual_time_ns_ = 0;  ///< start tag of the class that was drawn last
};

}  // namespace camrig::engine
