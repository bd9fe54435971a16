#include "core/world/world.h"

#include <algorithm>

#include "core/world/behaviour/stand_behaviour.h"
#include "core/world/scene_world.h"

namespace camrig::world {
namespace {

/// What actors take of the floor, unless they say so themselves.
double default_radius_m(const ActorSpec& spec) {
    return spec.object_class == person_class ? person_radius_m * spec.scale : 0.0;
}

}  // namespace

SceneWorld::SceneWorld(SceneRef scene, std::uint64_t seed)
    : scene_(std::move(scene)), seed_(seed), factory_(scene_), events_(scene_) {}

// Records that wait to be taken are not copied: who has this world has them.
SceneWorld::SceneWorld(const SceneWorld& other)
    : World(other),
      WorldView(other),
      scene_(other.scene_),
      seed_(other.seed_),
      factory_(other.factory_),
      now_ns_(other.now_ns_),
      statics_(other.statics_),
      history_(other.history_),
      present_(other.present_),
      is_current_(other.is_current_),
      last_id_(other.last_id_),
      class_numbers_(other.class_numbers_),
      crowd_(other.crowd_),
      groups_(other.groups_),
      events_(other.events_),
      record_count_(other.record_count_),
      flickers_(other.flickers_) {
    movers_.reserve(other.movers_.size());
    for (const auto& mover : other.movers_) {
        Mover& made = *movers_.emplace_back(std::make_unique<Mover>(*mover));
        made.behaviour = mover->behaviour->copy(factory_);
        if (!made.is_gone) by_name_[made.info->name] = &made;
    }
}

std::unique_ptr<World> SceneWorld::copy() const {
    thread_.check();
    return std::unique_ptr<World>(new SceneWorld(*this));
}

void SceneWorld::populate() {
    auto statics = std::make_shared<StaticSet>();
    statics->lights = scene_->lights;
    statics->environment = scene_->environment;
    statics->baked_light = scene_->baked_light;
    for (const ObjectSpec& object : scene_->objects) add_object(object, *statics);
    statics_ = std::move(statics);
    for (const ActorSpec& actor : scene_->actors) add_actor(actor);
    for (const ObjectSpec& object : scene_->objects)
        if (object.attach) attach(*as_mover(object.name), *object.attach);
    for (const ActorSpec& actor : scene_->actors)
        if (actor.attach) attach(*find(actor.name), *actor.attach);
    for (const EventSpec& event : scene_->events) events_.add(event, 0, {});
    run_events();
}

/// `turns`: the model is turned so that its front faces ahead (actors).
std::shared_ptr<const ObjectInfo> SceneWorld::new_info(const std::string& name, const std::string& object_class,
                                                       const std::string& model, bool turns) {
    auto info = std::make_shared<ObjectInfo>();
    info->id = ObjectId{++last_id_};
    info->name = name;
    info->object_class = object_class;
    const auto next_number = static_cast<std::uint32_t>(class_numbers_.size() + 1);
    info->class_number = class_numbers_.try_emplace(object_class, next_number).first->second;
    const SceneModel& of_scene = scene_->models.at(model);
    info->model = of_scene.model;
    info->model_name = model;
    if (turns) info->heading_from_model = of_scene.heading_from_model;
    info->look = look_of(*info->model, std::nullopt);
    return info;
}

void SceneWorld::add_object(const ObjectSpec& spec, StaticSet& statics) {
    const ModelRef& model = scene_->models.at(spec.model).model;
    auto info = new_info(spec.name, spec.object_class, spec.model, false);
    if (!spec.clip.empty()) {
        auto mover = std::make_unique<Mover>();
        mover->info = std::move(info);
        mover->model = spec.model;
        mover->scale = spec.scale;
        mover->behaviour = std::make_unique<Standing>(model, model->find_animation(spec.clip));
        mover->now.position = spec.position;
        mover->now.orientation = spec.orientation;
        add_mover(std::move(mover));
        return;
    }
    Instance instance;
    instance.info = std::move(info);
    instance.position = spec.position;
    instance.orientation = spec.orientation;
    instance.scale = spec.scale;
    statics.objects.push_back(std::move(instance));
}

Mover& SceneWorld::add_actor(const ActorSpec& spec) {
    const SceneModel& model = scene_->models.at(spec.model);
    auto mover = std::make_unique<Mover>();
    mover->info = new_info(spec.name, spec.object_class, spec.model, true);
    mover->model = spec.model;
    mover->is_actor = true;
    mover->spec = spec.behaviour;
    mover->heading_from_model = model.heading_from_model;
    mover->scale = spec.scale;
    if (spec.variant) wear(*mover, spec.variant);
    mover->radius_m = spec.radius_m.value_or(default_radius_m(spec));
    mover->now.position = spec.position;
    mover->now.orientation = spec.orientation;
    mover->behaviour = factory_.make(spec.behaviour, {.model = model.model, .radius_m = mover->radius_m}, false);
    return add_mover(std::move(mover));
}

void SceneWorld::forget_gone() {
    std::erase_if(movers_, [](const auto& mover) { return mover->is_gone; });
}

Mover& SceneWorld::add_mover(std::unique_ptr<Mover> mover) {
    // However many come and go while the world stands still, there are no more than that.
    if (movers_.size() >= max_world_actors) forget_gone();
    StepContext own = context();
    own.id = mover->id();
    own.radius_m = mover->radius_m;
    own.scale = mover->scale;
    mover->start(own);
    mover->before = mover->now;
    mover->was_arrived = mover->behaviour->arrived();
    by_name_[mover->info->name] = mover.get();
    movers_.push_back(std::move(mover));
    return *movers_.back();
}

StepContext SceneWorld::context() const {
    return {.now_ns = now_ns_, .step_ns = scene_->step_ns, .world_ns = now_ns_, .seed = seed_, .world = this};
}

void SceneWorld::see_crowd() {
    std::vector<Body> bodies;
    bodies.reserve(movers_.size());
    groups_.clear();
    for (const auto& mover : movers_) {
        if (auto body = mover->body(scene_->step_ns)) bodies.push_back(*body);
        if (const std::string* group = mover->behaviour->group()) groups_[*group].push_back(mover->id());
    }
    crowd_.assign(std::move(bodies));
}

void SceneWorld::step() {
    present();
    present_ = history_.push(std::move(present_));
    is_current_ = false;
    forget_gone();
    see_crowd();
    now_ns_ += scene_->step_ns;
    const StepContext now = context();
    for (const auto& mover : movers_) mover->before = mover->now;
    for (const auto& mover : movers_) mover->step(now);
    present_.arrived.resize(movers_.size());
    for (std::size_t i = 0; i < movers_.size(); ++i) present_.arrived[i] = movers_[i]->now;
    run_events();
}

void SceneWorld::advance_to(TimeNs world_ns) {
    thread_.check();
    CHECK(world_ns <= max_time_ns);
    while (now_ns_ < world_ns) step();
}

std::optional<glm::dvec3> SceneWorld::actor_position(const std::string& name) const {
    const Mover* mover = find(name);
    if (!mover || !mover->is_actor) return std::nullopt;
    const Mover* carrier = mover->held ? find(mover->held->carrier_name) : nullptr;
    if (!carrier) return mover->before.position;
    return hung_on(*mover->held, instance_of(carrier->record_before()), {}, mover->heading_from_model).position;
}

WorldView::Slot SceneWorld::group_slot(const std::string& group, std::uint32_t id) const {
    const auto found = groups_.find(group);
    if (found == groups_.end()) return {};
    const auto at = std::ranges::find(found->second, id);
    if (at == found->second.end()) return {0, found->second.size() + 1};
    return {static_cast<std::size_t>(at - found->second.begin()), found->second.size()};
}

Instance SceneWorld::hanging(const Mover& mover, const Mover& carrier) const {
    return hung_on(*mover.held, instance_of(carrier.record(scene_->step_ns)),
                   instance_of(mover.record(scene_->step_ns)), mover.heading_from_model);
}

const StepRecord& SceneWorld::present() const {
    if (is_current_) return present_;
    is_current_ = true;
    present_.world_ns = now_ns_;
    present_.statics = statics_;
    present_.movers.resize(movers_.size());
    std::size_t count = 0;
    for (const auto& mover : movers_)
        if (!mover->is_gone) mover->record(scene_->step_ns, present_.movers[count++]);
    present_.movers.resize(count);
    return present_;
}

SnapshotRef SceneWorld::snapshot(TimeNs world_ns) const {
    thread_.check();
    return history_.at(world_ns, present());
}

std::shared_ptr<const WorldPast> SceneWorld::past(TimeNs from_ns) const {
    thread_.check();
    return std::make_shared<const WorldPast>(history_.since(from_ns), present());
}

namespace {

void add_instances(Digest& digest, const std::vector<Instance>& objects) {
    digest.add(objects.size());
    for (const Instance& one : objects)
        digest.add(static_cast<std::uint32_t>(one.info->id), one.info->name, one.info->model_name, one.position,
                   one.orientation, one.scale);
}

void add_statics(Digest& digest, const StaticSet& statics) {
    add_instances(digest, statics.objects);
    add_instances(digest, statics.hidden);
    for (const Light& light : statics.lights)
        digest.add(light.name, light.color, light.intensity, light.position, light.direction);
    const Environment& around = statics.environment;
    digest.add(around.background, around.ambient_sky, around.ambient_ground, around.exposure, around.glow);
    if (around.daylight && around.daylight->clouds) digest.add(*around.daylight->clouds);
    if (around.fog.visibility_m > 0.0) digest.add(around.fog.visibility_m, around.fog.color);
}

}  // namespace

StateHash SceneWorld::state_hash() const {
    Digest digest;
    digest.add(seed_, now_ns_, scene_->step_ns, std::uint64_t{last_id_}, record_count_, movers_.size());
    for (const auto& mover : movers_) mover->add_to(digest);
    add_statics(digest, *statics_);
    events_.add_to(digest);
    for (const Flicker& one : flickers_)
        digest.add(one.light, one.intensity, one.period_ns, one.began_ns, one.until_ns, one.is_on);
    return {now_ns_, digest.value()};
}

std::vector<NamedDigest> SceneWorld::digests() const {
    std::vector<NamedDigest> all;
    for (const auto& mover : movers_) {
        Digest one;
        mover->add_to(one);
        all.push_back({"actor " + mover->info->name, one.value()});
    }
    Digest statics, events;
    add_statics(statics, *statics_);
    events_.add_to(events);
    all.push_back({"objects and lights", statics.value()});
    all.push_back({"events", events.value()});
    return all;
}

Result<std::unique_ptr<World>> World::create(SceneRef scene, std::uint64_t seed) {
    CHECK(scene != nullptr);
    const KnownNames names = names_of(*scene);
    for (const ActorSpec& actor : scene->actors)
        if (auto good = check_actor(actor, names, actor.name); !good) return std::unexpected(good.error());
    for (const ObjectSpec& object : scene->objects)
        if (auto good = check_object(object, names, object.name); !good) return std::unexpected(good.error());
    auto world = std::make_unique<SceneWorld>(std::move(scene), seed);
    world->populate();
    return world;
}

}  // namespace camrig::world
