#include "tools/view/rig_link.h"

#include <algorithm>
#include <utility>

#include <camrig/error.h>

namespace camrig::view {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr auto refresh_every = 200ms;
constexpr auto retry_after = 1000ms;
/// Short, so that the window closes without waiting for an event.
constexpr auto event_wait = 300ms;
constexpr std::size_t max_actors = 256;

std::vector<ActorRow> actors_of(const json& list) {
    std::vector<ActorRow> rows;
    for (const json& actor : list) {
        if (rows.size() == max_actors) break;
        const std::string clip = actor.value("clip", "");
        rows.push_back({actor.value("name", ""), clip.empty() ? actor.value("behaviour", "") : clip,
                        actor.at("position").get<client::Vector3>()});
    }
    return rows;
}

std::vector<EventRow> events_of(const json& list) {
    std::vector<EventRow> rows;
    for (const json& event : list)
        rows.push_back({event.value("name", ""), event.value("when", ""), event.value("fired", std::int64_t{0})});
    return rows;
}

json described(const client::Rig& rig) {
    const json all = rig.call("server.describe");
    json fields = json::array();
    for (const json& field : all.at("objects").at("camera")) {
        const std::string name = field.at("name");
        const bool has_own =
            name == "name" || name == "fps" || name == "vfov_deg" || name == "hfov_deg" || field.contains("by");
        if (!has_own) fields.push_back(field);
    }
    return {{"camera", std::move(fields)},
            {"outputs", all.at("kinds").at("output")},
            {"faults", all.at("kinds").at("fault")}};
}

}  // namespace

RigLink::RigLink(client::Rig rig, std::string own_camera, std::function<void()> changed)
    : rig_(std::move(rig)), own_camera_(std::move(own_camera)), changed_(std::move(changed)) {
    worker_.emplace([this] { return turn(); });
    events_.emplace([this] { return follow_events(); });
}

RigLink::~RigLink() {
    events_.reset();
    worker_.reset();
    do_edits();  // who closes the window right after "save" has saved
}

RigModel RigLink::model() const {
    const std::lock_guard lock(mutex_);
    return model_;
}

void RigLink::edit(std::string key, Edit edit) {
    {
        const std::lock_guard lock(mutex_);
        const auto same = std::ranges::find(edits_, key, &std::pair<std::string, Edit>::first);
        if (same != edits_.end()) {
            same->second = std::move(edit);
        } else if (edits_.size() < max_edits) {
            edits_.emplace_back(std::move(key), std::move(edit));
        } else {
            model_.refused = "too many changes wait for the rig";
        }
    }
    worker_->wake();
}

void RigLink::set_camera(const std::string& name, const std::string& key, client::CameraOptions options) {
    edit(name + "/" + key,
         [name, options = std::move(options)](const client::Rig& rig) { rig.camera(name).set(options); });
}

json RigLink::description() const {
    const std::lock_guard lock(mutex_);
    return description_;
}

bool RigLink::is_pending(const std::string& key) const {
    const std::lock_guard lock(mutex_);
    return in_work_.contains(key) ||
           std::ranges::find(edits_, key, &std::pair<std::string, Edit>::first) != edits_.end();
}

bool RigLink::do_edits() {
    bool any = false;
    for (;;) {
        std::pair<std::string, Edit> next;
        {
            const std::lock_guard lock(mutex_);
            if (edits_.empty()) return any;
            next = std::move(edits_.front());
            edits_.pop_front();
            in_work_.insert(next.first);
        }
        any = true;
        std::string refused;
        try {
            next.second(rig_);
        } catch (const std::exception& why) {
            refused = why.what();
        }
        const std::lock_guard lock(mutex_);
        model_.refused = refused;
    }
}

void RigLink::refresh() {
    RigModel fresh;
    fresh.world = rig_.status();
    fresh.cameras = rig_.camera_states();
    std::erase_if(fresh.cameras, [&](const client::CameraState& camera) { return camera.name == own_camera_; });
    fresh.settings = std::make_shared<const json>(rig_.call("camera.list"));
    fresh.faults = std::make_shared<const json>(rig_.faults());
    json description = this->description().is_null() ? described(rig_) : json();
    fresh.actors = actors_of(rig_.actors());
    fresh.events = events_of(rig_.events());
    const std::lock_guard lock(mutex_);
    if (!description.is_null()) description_ = std::move(description);
    fresh.problem.clear();
    fresh.refused = model_.refused;
    fresh.firings = std::move(model_.firings);
    model_ = std::move(fresh);
}

std::chrono::milliseconds RigLink::turn() {
    auto rest = std::chrono::milliseconds(refresh_every);
    do_edits();
    try {
        refresh();
    } catch (const std::exception& why) {
        rest = retry_after;
        const std::lock_guard lock(mutex_);
        model_.problem = why.what();
    }
    {
        const std::lock_guard lock(mutex_);
        in_work_.clear();
    }
    changed_();
    return rest;
}

std::chrono::milliseconds RigLink::follow_events() {
    try {
        const json answer = rig_.wait_events(last_firing_, event_wait);
        const std::int64_t last = answer.at("last").get<std::int64_t>();
        const std::lock_guard lock(mutex_);
        if (last < last_firing_) model_.firings.clear();  // another rig, or another world
        for (const json& one : answer.at("events")) {
            model_.firings.push_back({one.at("sequence").get<std::int64_t>(), one.at("world_ns").get<std::int64_t>(),
                                      one.at("event").get<std::string>(), one.value("actor", "")});
            if (model_.firings.size() > RigModel::max_firings) model_.firings.pop_front();
        }
        last_firing_ = last;
        return 1ms;
    } catch (const std::exception&) {
        return retry_after;  // turn() says what is wrong
    }
}

}  // namespace camrig::view
