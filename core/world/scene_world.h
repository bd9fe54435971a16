#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/base/thread_check.h"
#include "core/world/behaviour/behaviour_factory.h"
#include "core/world/event/event_table.h"
#include "core/world/mover.h"
#include "core/world/read/check_names.h"
#include "core/world/world.h"

namespace camrig::world {

/// The World of a scene. Steps and snapshots are in world.cpp, what commands do in world_actors.cpp and
/// world_objects.cpp, events in world_events.cpp.
class SceneWorld final : public World, private WorldView {
public:
    SceneWorld(SceneRef scene, std::uint64_t seed);
    void populate();

    const Scene& scene() const override { return *scene_; }
    void advance_to(TimeNs world_ns) override;
    TimeNs last_step_ns() const override { return now_ns_; }
    SnapshotRef snapshot(TimeNs world_ns) const override;
    std::shared_ptr<const WorldPast> past(TimeNs from_ns) const override;

    std::vector<ActorReport> actors() const override;
    Result<ActorReport> spawn_actor(const ActorSpec& spec) override;
    Result<void> remove_actor(const std::string& name) override;
    Result<ActorReport> change_actor(const ActorPatch& patch) override;
    Result<void> steer_actors(std::span<const SteerSpec> steers) override;

    Result<void> spawn_object(const ObjectSpec& spec) override;
    Result<void> change_object(const ObjectPatch& patch) override;
    Result<void> remove_object(const std::string& name) override;

    Result<void> check_mount(const Mount& mount, const std::string& path) const override;

    std::vector<EventReport> events() const override { return events_.reports(); }
    Result<EventReport> add_event(const EventSpec& spec) override;
    Result<void> remove_event(const std::string& name) override;
    Result<void> act(const std::vector<Action>& actions) override;
    std::vector<EventRecord> take_records() override { return std::exchange(records_, {}); }
    std::vector<CameraMove> take_camera_moves() override { return std::exchange(camera_moves_, {}); }
    std::vector<Departure> take_departures() override { return std::exchange(departures_, {}); }

    std::unique_ptr<World> copy() const override;
    std::size_t object_count() const override;
    std::size_t actor_count() const override {
        return static_cast<std::size_t>(
            std::ranges::count_if(movers_, [](const auto& mover) { return mover->is_actor && !mover->is_gone; }));
    }
    StateHash state_hash() const override;
    std::vector<NamedDigest> digests() const override;

private:
    friend struct ActionRun;
    SceneWorld(const SceneWorld& other);

    // WorldView: the world at the step before.
    const Crowd& crowd() const override { return crowd_; }
    std::optional<glm::dvec3> actor_position(const std::string& name) const override;
    Slot group_slot(const std::string& group, std::uint32_t id) const override;
    std::uint64_t last_firing(const std::string& event) const override { return events_.last_firing(event); }
    std::uint64_t last_firing() const override { return events_.last_firing(); }

    // world.cpp
    std::shared_ptr<const ObjectInfo> new_info(const std::string& name, const std::string& object_class,
                                               const std::string& model, bool turns);
    void add_object(const ObjectSpec& spec, StaticSet& statics);
    Mover& add_actor(const ActorSpec& spec);
    /// From now on it looks like this variant of its model.
    static void wear(Mover& mover, std::optional<std::uint64_t> variant);
    Mover& add_mover(std::unique_ptr<Mover> mover);
    void forget_gone();
    void step();
    void see_crowd();
    StepContext context() const;
    /// Where a mover that hangs on something is now.
    Instance hanging(const Mover& mover, const Mover& carrier) const;
    /// The world as it is now.
    const StepRecord& present() const;

    // world_actors.cpp
    Mover* find(const std::string& name) const;
    Result<Mover*> need_actor(const std::string& name) const;
    KnownNames known_names() const;
    FollowGraph follows(const std::string& without) const;
    ActorReport report(const Mover& mover) const;
    void behave(Mover& mover, const BehaviourSpec& spec);
    Result<void> check_behave(const Mover& mover, const BehaviourSpec& spec, const std::string& path) const;
    /// Whether the mover may be put there, as far as backdrops say what is walkable.
    Result<void> check_place(const Mover& mover, const glm::dvec3& place, const std::string& path) const;
    Result<void> check_carrier(const std::string& name, const Attachment& to, const std::string& path) const;
    void attach(Mover& mover, const Attachment& to);
    void put_down(Mover& mover, const std::optional<glm::dvec3>& position);
    void remove(Mover& mover);
    /// The mover of this name, made of a static object when there is none yet.
    Mover* as_mover(const std::string& object);

    // world_objects.cpp
    Result<void> change_mover(Mover& mover, const ObjectPatch& patch);

    // world_events.cpp
    void keep(EventRecord record);
    void run_events();
    std::vector<Witness> witnesses();
    /// The static set to change: a new one, snapshots keep theirs.
    StaticSet& edit_statics();
    void run_flickers();

    SceneRef scene_;
    std::uint64_t seed_;
    BehaviourFactory factory_;
    TimeNs now_ns_ = 0;  ///< of the last step

    std::shared_ptr<const StaticSet> statics_;
    StepHistory history_;                         ///< the steps before this one
    mutable StepRecord present_;                  ///< `arrived` always; all of it when it is current
    mutable bool is_current_ = false;             ///< nothing has changed since present_ was made
    std::vector<std::unique_ptr<Mover>> movers_;  ///< in the order they came, by id
    std::map<std::string, Mover*> by_name_;       ///< those that are there
    std::uint32_t last_id_ = 0;
    std::map<std::string, std::uint32_t> class_numbers_;
    Crowd crowd_;
    std::map<std::string, std::vector<std::uint32_t>> groups_;  ///< ids of each, rising

    EventTable events_;
    std::vector<EventRecord> records_;  ///< not taken yet
    std::uint64_t record_count_ = 0;
    std::vector<CameraMove> camera_moves_;
    std::vector<Departure> departures_;
    struct Flicker {
        std::string light;  ///< its switch_name()
        float intensity = 0.0f;
        TimeNs period_ns = 0, began_ns = 0;
        std::optional<TimeNs> until_ns;
        bool is_on = true;
    };
    std::vector<Flicker> flickers_;

    mutable ThreadCheck thread_;
};

}  // namespace camrig::world
