#include "tools/view/rig_link.h"

#include <algorithm>
#include <array>
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

std::vector<ActorRow> rows_of(const std::vector<client::ActorState>& actors) {
    std::vector<ActorRow> rows;
    for (const client::ActorState& actor : actors) {
        if (rows.size() == max_actors) break;
        rows.push_back({actor.name, actor.clip.empty() ? actor.behaviour : actor.clip, actor.position});
    }
    return rows;
}

std::vector<EventRow> rows_of(const std::vector<client::EventState>& events) {
    std::vector<EventRow> rows;
    for (const client::EventState& event : events) rows.push_back({event.name, event.when, event.fired});
    return rows;
}

/// Fields that have a control of their own, in the panel of the camera.
constexpr std::array own_controls{"name", "size", "fps", "vfov_deg", "pose", "outputs"};

json described(const client::Rig& rig) {
    const json all = rig.call("server.describe");
    json fields = json::array();
    for (const json& field : all.at("objects").at("camera")) {
        const bool has_own = std::ranges::find(own_controls, field.at("name").get<std::string>()) != own_controls.end();
        if (!has_own && field.value("by", "") != "client") fields.push_back(field);
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

void RigLink::order(Edit edit) {
    std::string key;
    {
        const std::lock_guard lock(mutex_);
        key = "order/" + std::to_string(++orders_);
    }
    this->edit(std::move(key), std::move(edit));
}

void RigLink::tell(std::string words) {
    const std::lock_guard lock(mutex_);
    told_ = std::move(words);
}

std::optional<std::string> RigLink::take_told() {
    const std::lock_guard lock(mutex_);
    return std::exchange(told_, {});
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
    fresh.faults = std::make_shared<const std::vector<client::FaultState>>(rig_.faults());
    json description = this->description().is_null() ? described(rig_) : json();
    fresh.actors = rows_of(rig_.actors());
    fresh.events = rows_of(rig_.events());
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
        const client::EventLog log = rig_.wait_events(last_firing_, event_wait);
        const std::lock_guard lock(mutex_);
        if (log.last < last_firing_) model_.firings.clear();  // another rig, or another world
        for (const client::FiredEvent& one : log.events) {
            model_.firings.push_back({one.sequence, one.world_ns, one.event, one.actor});
            if (model_.firings.size() > RigModel::max_firings) model_.firings.pop_front();
        }
        last_firing_ = log.last;
        return 1ms;
    } catch (const std::exception&) {
        return retry_after;  // turn() says what is wrong
    }
}

}  // namespace camrig::view
