#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/base/image_size.h"
#include "core/world/baked/reflection_probes.h"

/// Light that was found before anything is drawn (`camrig bake`, core/bake): how much of what each source sends out
/// reaches each place of what stands still, over all bounces. It is transport and no light: sources may change their
/// colour and strength afterwards, and what arrives is a sum over them.
namespace camrig::world {

struct Scene;
struct Model;

enum class LightSource : std::uint8_t {
    sky,     ///< Environment::ambient_sky, from above the horizon, where nothing hides it
    ground,  ///< Environment::ambient_ground, from below
    glow,    ///< what is unlit or emissive, as the models have it
    lamp  ///< of Scene::lights one, or a group; of a directional one only what is reflected, its direct light is drawn
};

/// Of a unit vector: xy, yz, xz, x^2 - y^2 and 3 z^2 - 1, the spherical harmonics of l = 2 but for factors.
inline constexpr std::size_t product_count = 5;
template <typename Vector>
[[gnu::always_inline]] inline auto products_of(const Vector& v) {
    return std::array<decltype(v.x * v.y), product_count>{v.x * v.y, v.y * v.z, v.x * v.z, v.x * v.x - v.y * v.y,
                                                          v.z * v.z * 3.0f - 1.0f};
}

/// Light at one place in the open: on a surface with normal n it is mean + along * n + products * products_of(n).
/// Ramamoorthi and Hanrahan, An efficient representation for irradiance environment maps, 2001.
struct LightProbe {
    glm::vec3 mean{0.0f};
    glm::mat3 along{0.0f};  ///< column i: by the i-th coordinate of the normal, world
    std::array<glm::vec3, product_count> products{};

    /// Radiance from that direction, times its share of all directions (in shading's units: what lights a surface that
    /// faces it by E is E / 4).
    void add(const glm::vec3& light, const glm::vec3& towards);
    LightProbe& operator+=(const LightProbe& other);
    LightProbe scaled(const glm::vec3& by) const;
};

/// What a source of strength 1 in each channel gives, in units of shading: irradiance over pi.
struct LightLayer {
    LightSource source = LightSource::sky;
    std::vector<std::size_t> lamps;     ///< of LightSource::lamp: into Scene::lights, alike in colour and strength
    std::vector<std::uint32_t> texels;  ///< of the map, top row first, as packed_light()
    std::vector<LightProbe> probes;     ///< of the grid, x fastest
    /// What reflection probes see of it, as radiance in units of shading: probe after probe, levels_of_probe(), rows;
    /// packed as texels.
    std::vector<std::uint32_t> reflections;
};

/// A primitive cut into charts that lie flat in the map: vertices on their borders are there once for each chart.
struct BakedPrimitive {
    static constexpr int max_side = 4096;  ///< of its rectangle, in texels

    std::vector<std::uint32_t> vertices;  ///< of the file, for each of its own
    std::vector<std::uint32_t> indices;
    std::vector<glm::vec2> coordinates;  ///< of its own vertices in its rectangle of the map, in texels
    ImageSize size{0, 0};                ///< of that rectangle; 0x0: it takes no part, and is as in the file
};

/// Where a primitive of a node of an object has its rectangle.
struct BakedSurface {
    int node = 0;
    std::size_t primitive = 0;  ///< among all of the model
    std::uint16_t x = 0, y = 0;
    friend bool operator==(const BakedSurface&, const BakedSurface&) = default;
};
/// By node, then primitive.
inline bool is_before(const BakedSurface& a, const BakedSurface& b) {
    return a.node != b.node ? a.node < b.node : a.primitive < b.primitive;
}

/// An object as it stood then. Elsewhere it has no light of the map.
struct BakedObject {
    std::string name;
    std::string model;  ///< the scene's name of it; another one under this name has other charts
    glm::dvec3 position{0.0};
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0};
    double scale = 1.0;
    std::vector<BakedSurface> surfaces;  ///< in the order of is_before()
};

/// Places in the open, at the corners of cubes.
struct ProbeGrid {
    glm::dvec3 first{0.0};
    double spacing_m = 1.0;
    glm::ivec3 count{0};
    std::vector<std::uint8_t> is_open;  ///< 0: inside of something

    std::size_t size() const {
        return static_cast<std::size_t>(count.x) * static_cast<std::size_t>(count.y) *
               static_cast<std::size_t>(count.z);
    }
};

struct BakedModel {
    std::string name;                        ///< of Scene::models
    std::vector<BakedPrimitive> primitives;  ///< mesh after mesh
};

struct BakedLight {
    std::uint64_t key = 0;  ///< light_key() of the scene that it was made for
    ImageSize size{0, 0};   ///< of the map
    std::vector<LightLayer> layers;
    std::vector<BakedModel> models;
    std::vector<BakedObject> objects;
    ProbeGrid grid;
    ReflectionProbes reflection_probes;
};
using BakedLightRef = std::shared_ptr<const BakedLight>;

/// Follows from all that decides where light goes: shapes and materials of what stands still, and where lamps are. Not
/// from colours and strengths of sources, nor from what moves.
std::uint64_t light_key(const Scene& scene);

/// The model with its primitives cut; the light's models name it.
std::shared_ptr<const Model> cut_model(const Model& model, const BakedModel& by);

/// Puts the light into the scene that it was made for: cuts its models.
void use_baked_light(Scene& scene, BakedLightRef light);

}  // namespace camrig::world
