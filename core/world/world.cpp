#include "core/world/world.h"

#include <atomic>
#include <map>

#include "core/base/thread_check.h"
#include "core/world/behaviour/route_behaviour.h"
#include "core/world/behaviour/stand_behaviour.h"
#include "core/world/interpolate.h"

namespace camrig {
namespace {

/// The key of the renderer's caches must differ between two worlds of one process; pictures never depend on it.
std::uint64_t next_revision() {
    static std::atomic<std::uint64_t> last{0};
    return ++last;
}

/// Corners are taken wider at speed; steps of half a metre, so that actors of one route share its path.
double corner_radius_m(double speed_m_s) {
    return std::max(0.5, 0.5 * std::ceil(speed_m_s / 3.0));
}

/// Something that moves: an actor, or an object that plays a clip.
struct Mover {
    std::shared_ptr<const ObjectInfo> info;
    std::unique_ptr<Behaviour> behaviour;
    glm::dquat heading_from_model{1.0, 0.0, 0.0, 0.0};
    double scale = 1.0;
    ActorState before, now;
};

class SceneWorld final : public World {
public:
    SceneWorld(SceneRef scene, std::uint64_t seed) : scene_(std::move(scene)), seed_(seed) {}
    Result<void> populate();

    const Scene& scene() const override { return *scene_; }
    void advance_to(TimeNs world_ns) override;
    SnapshotRef snapshot(TimeNs world_ns) const override;

private:
    using PathKey = std::pair<std::string, double>;
    std::shared_ptr<const ObjectInfo> new_info(const std::string& name, const std::string& object_class,
                                               const ModelRef& model);
    Result<void> add_object(const ObjectSpec& spec, StaticSet& statics);
    Result<void> add_actor(const ActorSpec& spec, std::map<PathKey, std::shared_ptr<const RoutePath>>& paths);
    Result<const SceneModel*> model_of(const std::string& owner, const std::string& name) const;
    void add_mover(Mover mover);

    SceneRef scene_;
    std::uint64_t seed_;
    std::shared_ptr<const StaticSet> statics_;
    std::vector<Mover> movers_;
    std::uint32_t last_id_ = 0;
    TimeNs now_ns_ = 0;  ///< of the last step
    mutable ThreadCheck thread_;
};

Result<int> clip_of(const std::string& owner, const Model& model, const std::string& clip) {
    if (clip.empty()) return -1;
    const int index = model.find_animation(clip);
    if (index < 0) return error(ErrorKind::not_found, owner + ": its model has no clip '" + clip + "'");
    return index;
}

Result<void> SceneWorld::populate() {
    auto statics = std::make_shared<StaticSet>();
    statics->revision = next_revision();
    statics->lights = scene_->lights;
    statics->environment = scene_->environment;
    for (const ObjectSpec& object : scene_->objects)
        if (auto done = add_object(object, *statics); !done) return done;
    statics_ = std::move(statics);
    std::map<PathKey, std::shared_ptr<const RoutePath>> paths;
    for (const ActorSpec& actor : scene_->actors)
        if (auto done = add_actor(actor, paths); !done) return done;
    return {};
}

std::shared_ptr<const ObjectInfo> SceneWorld::new_info(const std::string& name, const std::string& object_class,
                                                       const ModelRef& model) {
    auto info = std::make_shared<ObjectInfo>();
    info->id = ObjectId{++last_id_};
    info->name = name;
    info->object_class = object_class;
    info->model = model;
    return info;
}

Result<const SceneModel*> SceneWorld::model_of(const std::string& owner, const std::string& name) const {
    const auto found = scene_->models.find(name);
    if (found == scene_->models.end()) return error(ErrorKind::not_found, owner + ": no model '" + name + "'");
    return &found->second;
}

Result<void> SceneWorld::add_object(const ObjectSpec& spec, StaticSet& statics) {
    const auto model = model_of(spec.name, spec.model);
    if (!model) return std::unexpected(model.error());
    const ModelRef& ref = (*model)->model;
    const auto clip = clip_of(spec.name, *ref, spec.clip);
    if (!clip) return std::unexpected(clip.error());
    auto info = new_info(spec.name, spec.object_class, ref);
    if (*clip >= 0) {
        Mover mover;
        mover.info = std::move(info);
        mover.scale = spec.scale;
        mover.behaviour = std::make_unique<Standing>(ref, *clip, spec.position, spec.orientation);
        add_mover(std::move(mover));
        return {};
    }
    Instance instance;
    instance.info = std::move(info);
    instance.position = spec.position;
    instance.orientation = spec.orientation;
    instance.scale = spec.scale;
    statics.objects.push_back(std::move(instance));
    return {};
}

Result<void> SceneWorld::add_actor(const ActorSpec& spec, std::map<PathKey, std::shared_ptr<const RoutePath>>& paths) {
    const auto model = model_of(spec.name, spec.model);
    if (!model) return std::unexpected(model.error());
    const ModelRef& ref = (*model)->model;
    Mover mover;
    mover.heading_from_model = (*model)->heading_from_model;
    mover.scale = spec.scale;
    if (const auto* stand = std::get_if<StandBehaviour>(&spec.behaviour)) {
        const auto clip = clip_of(spec.name, *ref, stand->clip);
        if (!clip) return std::unexpected(clip.error());
        mover.behaviour = std::make_unique<Standing>(ref, *clip, spec.position, spec.orientation);
    } else {
        const auto& walk = std::get<RouteBehaviour>(spec.behaviour);
        const auto clip = clip_of(spec.name, *ref, walk.clip);
        if (!clip) return std::unexpected(clip.error());
        const auto route = scene_->routes.find(walk.route);
        if (route == scene_->routes.end())
            return error(ErrorKind::not_found, spec.name + ": no route '" + walk.route + "'");
        const double radius = corner_radius_m(walk.speed_m_s);
        auto& path = paths[{walk.route, radius}];
        if (!path) {
            auto created = RoutePath::create(route->second, radius);
            if (!created) return at(spec.name, created.error());
            path = std::make_shared<RoutePath>(std::move(*created));
        }
        mover.behaviour = std::make_unique<RouteWalk>(RouteWalk::Options{.path = path,
                                                                         .mode = walk.mode,
                                                                         .speed_m_s = walk.speed_m_s,
                                                                         .start_m = walk.start_m,
                                                                         .model = ref,
                                                                         .animation = *clip,
                                                                         .scale = spec.scale});
    }
    mover.info = new_info(spec.name, spec.object_class, ref);
    add_mover(std::move(mover));
    return {};
}

void SceneWorld::add_mover(Mover mover) {
    mover.behaviour->step({.now_ns = now_ns_, .step_ns = scene_->step_ns, .seed = seed_}, mover.now);
    mover.before = mover.now;
    movers_.push_back(std::move(mover));
}

void SceneWorld::advance_to(TimeNs world_ns) {
    thread_.check();
    CHECK(world_ns <= max_time_ns);
    while (now_ns_ < world_ns) {
        now_ns_ += scene_->step_ns;
        const StepContext context{.now_ns = now_ns_, .step_ns = scene_->step_ns, .seed = seed_};
        for (Mover& mover : movers_) {
            mover.before = mover.now;
            mover.behaviour->step(context, mover.now);
        }
    }
}

/// `remaining_ns` of the step are still to come at the moment asked for.
ClipState clip_before(const ClipPlay& play, TimeNs remaining_ns, TimeNs step_ns) {
    ClipState clip{.animation = play.animation, .phase_ns = play.phase_ns, .weight = play.weight};
    if (play.duration_ns <= 0) return clip;
    const WideInt back = static_cast<WideInt>(play.advance_ns) * remaining_ns / step_ns;
    const WideInt phase = (play.phase_ns - back) % play.duration_ns;
    clip.phase_ns = static_cast<TimeNs>(phase < 0 ? phase + play.duration_ns : phase);
    return clip;
}

SnapshotRef SceneWorld::snapshot(TimeNs world_ns) const {
    thread_.check();
    const TimeNs step_ns = scene_->step_ns;
    const TimeNs remaining_ns = now_ns_ - world_ns;
    CHECK(remaining_ns >= 0 && remaining_ns <= step_ns);
    auto snapshot = std::make_shared<Snapshot>();
    snapshot->world_ns = world_ns;
    snapshot->statics = statics_;
    snapshot->movers.reserve(movers_.size());
    const double share = static_cast<double>(step_ns - remaining_ns) / static_cast<double>(step_ns);
    for (const Mover& mover : movers_) {
        Instance instance;
        instance.info = mover.info;
        instance.scale = mover.scale;
        const bool on_step = remaining_ns == 0;
        const glm::dvec3 moved = mover.now.position - mover.before.position;
        instance.position = on_step ? mover.now.position : mover.before.position + moved * share;
        const glm::dquat turned =
            on_step ? mover.now.orientation : slerp_shortest(mover.before.orientation, mover.now.orientation, share);
        instance.orientation = glm::normalize(turned * mover.heading_from_model);
        instance.velocity = moved / (static_cast<double>(step_ns) * 1e-9);
        for (const ClipPlay& play : mover.now.clips) instance.clips.push_back(clip_before(play, remaining_ns, step_ns));
        snapshot->movers.push_back(std::move(instance));
    }
    return snapshot;
}

}  // namespace

Result<std::unique_ptr<World>> World::create(SceneRef scene, std::uint64_t seed) {
    CHECK(scene != nullptr);
    auto world = std::make_unique<SceneWorld>(std::move(scene), seed);
    if (auto done = world->populate(); !done) return std::unexpected(done.error());
    return world;
}

}  // namespace camrig
