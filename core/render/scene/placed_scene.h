#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/render/scene/body_capsules.h"
#include "core/render/scene/contact_shadows.h"
#include "core/render/scene/light_selection.h"
#include "core/render/scene/prepared_model.h"
#include "core/world/backdrop/backdrop.h"
#include "core/world/posed_model.h"
#include "core/world/snapshot.h"

/// The world of one instant for renderers, without any of their devices: what is where, with which light on it.
namespace camrig::render::scene {

/// Levels of detail of a primitive, as bits: 1 is the full mesh, with all vertices.
using LevelSet = std::uint32_t;

/// Vertices of one skinned or morphed primitive at one instant: made when the first camera sees them, used by all.
struct DeformedVertices {
    const world::PosedModel* pose = nullptr;
    int node = 0;
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
    LevelSet made = 0;  ///< of which levels the vertices are made

    /// Those of the levels that are not made yet.
    LevelSet missing(LevelSet levels) const { return (made & 1) != 0 ? 0 : levels & ~made; }
};

/// One draw placed in the world, the same for all cameras.
struct PlacedSurface {
    const world::ObjectInfo* object = nullptr;  ///< the snapshot holds it
    const world::ModelRef* source = nullptr;    ///< of the model: the object's, or contact_model()
    const PreparedModel* model = nullptr;
    const PreparedPrimitive* primitive = nullptr;
    int node = 0;  ///< of the model; not of a contact shadow
    glm::dmat4 world_from_local{1.0};
    world::Box bounds;     ///< local
    glm::vec3 tint{1.0f};  ///< its object's, of the material's base color
    int light_set = 0;     ///< into PlacedScene::light_sets; that of what is not lit is empty
    /// Of its rectangle in the map of baked light; nullopt: it has none, or does not stand as it did then.
    std::optional<glm::ivec2> light_map_at{};
    bool is_mirrored = false;        ///< by world_from_local
    bool turns_clockwise = false;    ///< corners that run counter-clockwise in the file, seen from the front
    bool is_contact_shadow = false;  ///< not at quality fast
    int deformation = -1;            ///< into those of its PlacedSurfaces; -1: rigid
    std::size_t index = 0;           ///< into PlacedSurfaces::all

    /// Of its bounds, in the world.
    glm::dvec3 middle() const {
        return glm::dvec3(world_from_local * glm::dvec4(0.5f * (bounds.min + bounds.max), 1.0));
    }
};

/// The different light sets of an instant; few, because neighbours share theirs.
class LightTable {
public:
    int add(const LightSet& set);
    const LightSet& operator[](int index) const { return sets_[static_cast<std::size_t>(index)]; }
    int size() const { return static_cast<int>(sets_.size()); }
    void truncate(int size) { sets_.resize(static_cast<std::size_t>(size)); }

private:
    std::vector<LightSet> sets_;
};

/// All draws of some instances in their poses. Storage is reused from instant to instant.
class PlacedSurfaces {
public:
    void clear();
    void add(const world::Instance& instance, PreparedModels& models, LightTable& light_sets,
             std::span<const world::Light> lights, float exposure);
    /// Those from `first` on are of this object: where they have their baked light.
    void find_baked(std::size_t first, const world::BakedObject& object);
    /// Under the lights of another static set.
    void light_anew(LightTable& light_sets, std::span<const world::Light> lights, float exposure);
    std::span<const PlacedSurface> all() const { return surfaces_; }
    const PlacedBodies& bodies() const { return bodies_; }
    /// Those that are blended, into all().
    std::span<const std::size_t> blended() const { return blended_; }
    /// Makes the vertices of these levels of a deformed surface. Different surfaces from different threads; one surface
    /// from one thread at a time.
    const DeformedVertices& deform(const PlacedSurface& surface, LevelSet levels = 1);
    const DeformedVertices& deformed(const PlacedSurface& surface) const;
    std::size_t deformation_count() const { return deformations_used_; }
    /// How many of the deformations are made.
    std::uint64_t made() const;

private:
    PlacedSurface& place(const PreparedPrimitive& primitive, const PreparedModel& model, const world::ModelRef& source,
                         const world::ObjectInfo& object);
    world::PosedModel& next_pose();
    DeformedVertices& next_deformation();

    std::vector<PlacedSurface> surfaces_;
    std::vector<std::size_t> blended_;
    std::deque<DeformedVertices> deformations_;
    std::deque<world::PosedModel> poses_;
    ContactShadows contacts_;
    PlacedBodies bodies_;
    std::size_t deformations_used_ = 0, poses_used_ = 0;
};

/// A snapshot whose objects are placed and posed, once for all views. What stands still stays placed until the
/// snapshot's static set is another one.
///
/// Thread: one at a time, but for PlacedSurfaces::deform. Several scenes may share the prepared models.
class PlacedScene {
public:
    explicit PlacedScene(std::shared_ptr<PreparedModels> models) : models_(std::move(models)) {}

    /// Becomes the scene of this instant.
    void place(const world::SnapshotRef& snapshot);
    /// Holds nothing any more; what is placed next counts as another world.
    void clear();

    const world::SnapshotRef& snapshot() const { return snapshot_; }
    const world::Environment& environment() const { return static_set_->environment; }
    std::span<const world::Light> lights() const { return static_set_->lights; }
    bool has_baked_light() const { return static_set_->baked_light != nullptr; }
    const LightTable& light_sets() const { return light_sets_; }
    PlacedSurfaces& statics() { return statics_; }
    const PlacedSurfaces& statics() const { return statics_; }
    PlacedSurfaces& movers() { return movers_; }
    const PlacedSurfaces& movers() const { return movers_; }
    const PlacedSurfaces& group_of(bool is_static) const { return is_static ? statics_ : movers_; }
    /// The catchers and proxies of a backdrop, which stand still; null: it has none of its own. Good as long as the
    /// backdrop.
    const PlacedSurfaces* proxies_of(const std::shared_ptr<const world::Backdrop>& backdrop);
    /// Of all backdrops that were asked for.
    template <typename Use>
    void each_proxy(const Use& use) const {
        for (const auto& [key, one] : proxies_)
            if (const auto backdrop = one.of.lock())  // its models are kept no longer than it
                for (const PlacedSurface& surface : one.placed.all()) use(surface);
    }

    std::uint64_t statics_number() const { return statics_number_; }  ///< counts the static sets
    std::uint64_t objects_number() const { return objects_number_; }  ///< counts those with other objects
    std::uint64_t proxies_number() const { return proxies_number_; }  ///< counts the sets of proxies

    /// Deformed meshes of movers since the start, once an instant: those that were made, and those that no camera saw.
    std::uint64_t meshes_made() const { return meshes_made_ + movers_.made(); }
    std::uint64_t meshes_unseen() const { return meshes_unseen_ + movers_.deformation_count() - movers_.made(); }

private:
    void place_statics(const std::shared_ptr<const world::StaticSet>& statics);
    /// Those of backdrops that are gone are forgotten; of those that are new, the lights stay from now on.
    void keep_proxies();

    struct Proxies {
        std::weak_ptr<const world::Backdrop> of;
        PlacedSurfaces placed;
    };

    std::shared_ptr<PreparedModels> models_;
    world::SnapshotRef snapshot_;
    std::shared_ptr<const world::StaticSet> static_set_;
    std::uint64_t statics_number_ = 0, objects_number_ = 0;
    PlacedSurfaces statics_, movers_;
    LightTable light_sets_;  ///< those of the statics first, then the movers' of this instant
    int static_light_sets_ = 0;
    std::map<const world::Backdrop*, Proxies> proxies_;
    std::uint64_t proxies_number_ = 0;
    bool has_new_proxies_ = false, has_new_statics_ = false;
    int own_light_sets_ = 0;                             ///< of the statics, without those of proxies
    std::uint64_t meshes_made_ = 0, meshes_unseen_ = 0;  ///< in the instants before this one
};

}  // namespace camrig::render::scene
