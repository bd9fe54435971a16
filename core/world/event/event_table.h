#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/base/digest.h"
#include "core/world/event/event_spec.h"
#include "core/world/scene.h"

namespace camrig::world {

/// An actor as the triggers see it, at the end of a step.
struct Witness {
    std::uint32_t id = 0;
    const std::string* name = nullptr;
    const std::string* object_class = nullptr;
    glm::dvec2 position{0.0};
    bool has_arrived = false;  ///< in this step
    bool is_carried = false;   ///< then it comes, leaves and meets only where it is put down
};

/// The events that wait, and which of them fire. Thread: the world's.
class EventTable {
public:
    explicit EventTable(SceneRef scene) : scene_(std::move(scene)) {}

    /// `now_ns`: times count from there; actors that are in an area already do not enter it.
    void add(const EventSpec& spec, TimeNs now_ns, const std::vector<Witness>& actors);
    bool remove(const std::string& name);
    bool contains(const std::string& name) const;
    std::vector<EventSpec> specs() const;
    std::vector<EventReport> reports() const;

    /// Firings of all events are numbered from 1. 0: it has not fired.
    std::uint64_t last_firing(const std::string& name) const;
    std::uint64_t last_firing() const { return firings_; }

    /// Adds all that decides which fire when.
    void add_to(Digest& digest) const;

    struct Firing {
        std::string event;
        std::string actor;
        std::shared_ptr<const EventSpec> spec;
    };
    /// The events that fire at the end of the step at `now_ns`, in the order they were added.
    std::vector<Firing> due(TimeNs now_ns, const std::vector<Witness>& actors);
    /// Counts it; false when the event has fired as often as it may, or is gone.
    bool claim(const Firing& firing);
    /// Those that fire at once because of it. There is no circle, because check_event_loop() has let them in.
    std::vector<Firing> after(const Firing& firing, TimeNs now_ns);

private:
    struct Entry {
        std::shared_ptr<const EventSpec> spec;
        std::int64_t fired = 0;
        TimeNs next_ns = 0;              ///< of a time trigger
        std::vector<TimeNs> later;       ///< delayed firings after another event, sorted as they come
        std::set<std::uint32_t> inside;  ///< of a border
        bool is_near = false;            ///< of a meeting

        bool is_spent() const { return spec->limit > 0 && fired >= spec->limit; }
    };
    void look(Entry& entry, TimeNs now_ns, const std::vector<Witness>& actors, std::vector<Firing>& out) const;

    SceneRef scene_;
    std::vector<Entry> entries_;
    std::map<std::string, std::uint64_t> last_;  ///< number of each event's latest firing
    std::uint64_t firings_ = 0;
};

}  // namespace camrig::world
