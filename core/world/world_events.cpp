#include <algorithm>
#include <cmath>
#include <deque>

#include "core/base/random.h"
#include "core/world/daylit.h"
#include "core/world/photometric.h"
#include "core/world/scene_world.h"

// What events do, at the end of a step.
namespace camrig::world {
namespace {

constexpr std::size_t max_records = 4096;
constexpr std::size_t max_flickers = 256;
constexpr std::size_t max_camera_moves = 1024;  ///< of one instant: how soon they are taken must not count
/// The stream of a flickering light's chance; no actor has it.
constexpr std::uint64_t flicker_stream = std::uint64_t{1} << 40;

void set_intensity(StaticSet& statics, const std::string& lights, float intensity) {
    for (Light& light : statics.lights)
        if (switch_name(light) == lights) light.intensity = intensity;
}

}  // namespace

/// Does one action of an event; an error tells why it could not be done, and then it has changed nothing.
struct ActionRun {
    SceneWorld& world;
    EventRecord& record;

    Result<Mover*> actor(const std::string& name) const { return world.need_actor(name); }

    Result<void> operator()(const BehaveAction& action) const {
        const auto mover = actor(action.actor);
        if (!mover) return std::unexpected(mover.error());
        if (auto good = world.check_behave(**mover, action.behaviour, ""); !good) return good;
        world.behave(**mover, action.behaviour);
        return {};
    }
    Result<void> operator()(const StopAction& action) const {
        const auto mover = actor(action.actor);
        if (!mover) return std::unexpected(mover.error());
        (*mover)->held_at_ns = world.now_ns_;
        (*mover)->played.reset();
        if (!action.clip.empty()) return play(**mover, action.clip, 1.0, std::nullopt);
        return {};
    }
    Result<void> operator()(const StartAction& action) const {
        const auto mover = actor(action.actor);
        if (!mover) return std::unexpected(mover.error());
        (*mover)->held_at_ns.reset();
        (*mover)->played.reset();
        return {};
    }
    Result<void> play(Mover& mover, const std::string& clip, double speed, std::optional<TimeNs> duration_ns) const {
        if (auto good = check_clip(*mover.info->model, clip, "clip"); !good) return good;
        mover.played.reset();
        if (clip.empty()) return {};
        mover.played = Mover::Played{.animation = mover.info->model->find_animation(clip),
                                     .speed_ppm = std::llround(speed * 1e6),
                                     .began_ns = world.now_ns_,
                                     .until_ns = {}};
        if (duration_ns) mover.played->until_ns = world.now_ns_ + *duration_ns;
        return {};
    }
    Result<void> operator()(const PlayAction& action) const {
        const auto mover = actor(action.actor);
        if (!mover) return std::unexpected(mover.error());
        return play(**mover, action.clip, action.speed, action.duration_ns);
    }
    Result<void> operator()(const SpawnAction& action) const {
        const auto spawned = world.spawn_actor(action.actor);
        if (!spawned) return std::unexpected(spawned.error());
        return {};
    }
    Result<void> operator()(const RemoveAction& action) const { return world.remove_actor(action.actor); }
    Result<void> operator()(const PickUpAction& action) const {
        if (auto good = check_attachment(action.to, world.known_names(), ""); !good) return good;
        if (auto good = world.check_carrier(action.object, action.to, ""); !good) return good;
        Mover* mover = world.as_mover(action.object);
        if (!mover) return error(ErrorKind::not_found, "object: there is no '" + action.object + "'");
        world.attach(*mover, action.to);
        return {};
    }
    Result<void> operator()(const PutDownAction& action) const {
        Mover* mover = world.find(action.object);
        if (!mover || !mover->held)
            return error(ErrorKind::invalid_argument, "object: nobody carries '" + action.object + "'");
        world.put_down(*mover, action.position);
        return {};
    }
    Result<void> operator()(const LightAction& action) const {
        StaticSet& statics = world.edit_statics();
        const auto light = std::ranges::find(statics.lights, action.light, switch_name);
        if (light == statics.lights.end()) return error(ErrorKind::not_found, "light: no light '" + action.light + "'");
        auto& flickers = world.flickers_;
        // A flicker that is told something else ends as it was meant to be.
        const auto running = std::ranges::find(flickers, action.light, &SceneWorld::Flicker::light);
        if (running != flickers.end()) {
            set_intensity(statics, action.light, running->intensity);
            flickers.erase(running);
        }
        if (action.intensity) set_intensity(statics, action.light, static_cast<float>(*action.intensity));
        if (const auto& in_unit = action.lux ? action.lux : action.candela)
            set_intensity(statics, action.light, static_cast<float>(*in_unit / *unit_lux(statics.environment)));
        if (action.color)
            for (Light& one : statics.lights)
                if (switch_name(one) == action.light) one.color = *action.color;
        if (action.flicker_hz > 0.0 && flickers.size() < max_flickers) {
            SceneWorld::Flicker flicker{.light = action.light,
                                        .intensity = light->intensity,
                                        .period_ns = std::max<TimeNs>(1, std::llround(1e9 / action.flicker_hz)),
                                        .began_ns = world.now_ns_,
                                        .until_ns = {}};
            if (action.duration_ns) flicker.until_ns = world.now_ns_ + *action.duration_ns;
            flickers.push_back(std::move(flicker));
        }
        return {};
    }
    Result<void> operator()(const EnvironmentAction& action) const {
        StaticSet& statics = world.edit_statics();
        Environment& environment = statics.environment;
        if (action.background) environment.background = *action.background;
        if (action.sky) environment.ambient_sky = *action.sky;
        if (action.ground) environment.ambient_ground = *action.ground;
        if (action.exposure) environment.exposure = static_cast<float>(*action.exposure);
        if (action.glow) environment.glow = static_cast<float>(*action.glow);
        if (action.fog) environment.fog = *action.fog;
        if (action.daylight) {
            environment.daylight = *action.daylight;
            // A new light comes last: baked light and flickers know the others by their numbers.
            if (std::ranges::find(statics.lights, sun_name, &Light::name) == statics.lights.end())
                statics.lights.push_back({.name = sun_name, .group = {}});
            apply_daylight(environment, statics.lights);
            const Light& sun = *std::ranges::find(statics.lights, sun_name, &Light::name);
            const auto flicker = std::ranges::find(world.flickers_, switch_name(sun), &SceneWorld::Flicker::light);
            if (flicker != world.flickers_.end()) {
                flicker->intensity = sun.intensity;
                if (!flicker->is_on) set_intensity(statics, flicker->light, 0.0f);
            }
            show_sky(statics);
        }
        return {};
    }
    Result<void> of_camera(const auto& action) const {
        auto& moves = world.camera_moves_;
        if (moves.size() >= max_camera_moves && moves[moves.size() - max_camera_moves].world_ns == world.now_ns_)
            return error(ErrorKind::resource_exhausted, "camera: too many moves at a time");
        moves.push_back({world.now_ns_, action});
        return {};
    }
    Result<void> operator()(const CameraAction& action) const { return of_camera(action); }
    Result<void> operator()(const FaultAction& action) const { return of_camera(action); }
    Result<void> operator()(const ClearFaultAction& action) const { return of_camera(action); }
    Result<void> operator()(const UserAction& action) const {
        record.data.push_back(action.data);
        return {};
    }
};

StaticSet& SceneWorld::edit_statics() {
    auto copy = std::make_shared<StaticSet>(*statics_);
    StaticSet& edited = *copy;
    statics_ = std::move(copy);
    return edited;
}

void SceneWorld::run_flickers() {
    for (std::size_t i = 0; i < flickers_.size();) {
        Flicker& flicker = flickers_[i];
        const bool ends = flicker.until_ns && now_ns_ >= *flicker.until_ns;
        const auto phase = static_cast<std::uint64_t>((now_ns_ - flicker.began_ns) / flicker.period_ns);
        const auto index = std::ranges::find(statics_->lights, flicker.light, switch_name) - statics_->lights.begin();
        const std::uint64_t stream = flicker_stream + static_cast<std::uint64_t>(index);
        const bool on = ends || random_unit(seed_, stream, phase) < 0.5;
        if (on != flicker.is_on) {
            set_intensity(edit_statics(), flicker.light, on ? flicker.intensity : 0.0f);
            flicker.is_on = on;
        }
        if (ends)
            flickers_.erase(flickers_.begin() + static_cast<std::ptrdiff_t>(i));
        else
            ++i;
    }
}

std::vector<Witness> SceneWorld::witnesses() {
    std::vector<Witness> all;
    all.reserve(movers_.size());
    for (const auto& mover : movers_) {
        if (!mover->is_actor || mover->is_gone) continue;
        Witness& one = all.emplace_back(mover->id(), &mover->info->name, &mover->info->object_class,
                                        glm::dvec2(mover->now.position));
        one.is_carried = mover->held.has_value();
        if (one.is_carried) continue;
        const bool arrived = mover->behaviour->arrived();
        one.has_arrived = arrived && !mover->was_arrived;
        mover->was_arrived = arrived;
    }
    return all;
}

void SceneWorld::run_events() {
    if (!flickers_.empty()) run_flickers();
    const auto first = events_.due(now_ns_, witnesses());
    if (first.empty()) return;
    std::deque<EventTable::Firing> firings(first.begin(), first.end());
    while (!firings.empty()) {
        const EventTable::Firing firing = std::move(firings.front());
        firings.pop_front();
        if (!events_.claim(firing)) continue;
        EventRecord record;
        record.world_ns = now_ns_;
        record.event = firing.event;
        record.actor = firing.actor;
        for (std::size_t i = 0; i < firing.spec->actions.size(); ++i) {
            const auto done = std::visit(ActionRun{*this, record}, firing.spec->actions[i]);
            if (!done) record.errors.push_back("do[" + std::to_string(i) + "]: " + done.error().message);
        }
        keep(std::move(record));
        for (auto& next : events_.after(firing, now_ns_)) firings.push_back(std::move(next));
    }
}

void SceneWorld::keep(EventRecord record) {
    record.sequence = ++record_count_;
    if (records_.size() >= max_records) records_.erase(records_.begin(), records_.begin() + max_records / 2);
    records_.push_back(std::move(record));
}

Result<void> SceneWorld::act(const std::vector<Action>& actions) {
    thread_.check();
    KnownNames names = known_names();
    for (std::size_t i = 0; i < actions.size(); ++i) {
        if (auto good = check_action(actions[i], names, "do[" + std::to_string(i) + "]"); !good) return good;
        add_spawned(actions[i], names);
    }
    is_current_ = false;
    EventRecord record;
    record.world_ns = now_ns_;
    record.event = "event.act";
    for (std::size_t i = 0; i < actions.size(); ++i)
        if (auto done = std::visit(ActionRun{*this, record}, actions[i]); !done)
            return at("do[" + std::to_string(i) + "]", done.error());
    keep(std::move(record));
    return {};
}

Result<EventReport> SceneWorld::add_event(const EventSpec& spec) {
    thread_.check();
    if (events_.contains(spec.name))
        return error(ErrorKind::already_exists, "name: there is an event '" + spec.name + "'");
    const auto all = events_.specs();
    if (all.size() >= max_world_events)
        return error(ErrorKind::resource_exhausted, "a world has at most 1000 events; remove one");
    KnownNames names = known_names();
    names.events.insert(spec.name);
    for (const Action& action : spec.actions) add_spawned(action, names);
    if (auto good = check_event(spec, names, ""); !good) return std::unexpected(good.error());
    if (auto good = check_event_loop(spec, all, ""); !good) return std::unexpected(good.error());
    const auto* at = std::get_if<AtTime>(&spec.when);
    if (at && at->at_ns <= now_ns_)
        return error(ErrorKind::invalid_argument,
                     "when.at_s: is past; world time is " + std::to_string(static_cast<double>(now_ns_) * 1e-9) + " s");
    events_.add(spec, now_ns_ + 1, witnesses());
    return events_.reports().back();
}

Result<void> SceneWorld::remove_event(const std::string& name) {
    thread_.check();
    if (events_.remove(name)) return {};
    return error(ErrorKind::not_found, "name: there is no event '" + name.substr(0, 80) + "'; event.list lists them");
}

}  // namespace camrig::world
