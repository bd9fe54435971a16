#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "core/bake/area_lamps.h"
#include "core/bake/bake_team.h"
#include "core/bake/transport.h"
#include "core/render/scene/view_lights.h"

namespace camrig::bake {

/// Rays begin so far before their surface.
inline constexpr float lift_m = 5e-4f;
inline constexpr std::size_t max_layers = 64;

/// Light by layer.
using Gathered = std::array<glm::vec3, max_layers>;

/// The light that arrives at the texels of a map, by layer: from lamps directly, and bounce by bounce from the sky,
/// from what glows and from other texels. Afterwards, what comes to any other place from there.
///
/// Thread: one; solve() works on the team. The constant functions: any, after solve(). What it is made of must stay.
class TexelLight {
public:
    TexelLight(const RayScene& scene, const LightMap& map, std::span<const Source> sources,
               std::span<const world::Light> lamps, const TransportOptions& options, BakeTeam& team);

    /// False: it was ended.
    bool solve();
    /// By layer and texel, as LightLayer has it: without the direct light of directional lamps, which is drawn with its
    /// shadows. Once, as the last call.
    std::vector<std::vector<glm::vec3>> take_texels();

    /// Direct light of a lamp of colour and strength 1 at a place, for a surface that scatters it. front_share: of the
    /// light on its front; the rest is of what falls on its back.
    glm::vec3 direct(const MapPlace& place, std::size_t lamp, float front_share = 1.0f) const;
    /// What comes along a ray, added by layer. Rays that are sent to surfaces that are lamps count those.
    enum class AreaLampsCount : bool { no, yes };
    /// Whether what a smooth surface mirrors is what it sees there; else it is a share of all that comes to it.
    enum class MirrorsAreMet : bool { no, yes };
    struct Met {
        bool is_inside = false;  ///< of something
        float distance = std::numeric_limits<float>::infinity();
        glm::vec3 side{0.0f};  ///< of what it is inside of, where that is met: away from who is within
    };
    Met look(const Ray& ray, std::span<glm::vec3> sum, AreaLampsCount lamps = AreaLampsCount::no,
             MirrorsAreMet mirrors = MirrorsAreMet::yes) const;
    const AreaLamps& area_lamps() const { return area_lamps_; }
    /// The layer of what glows, which has the area lamps; the count of layers: there is none.
    std::size_t glow_layer() const { return glow_layer_; }

private:
    /// A texel has one light for both sides of what is thin: each counts by how far one can look from there, for from
    /// as far it is seen. A flag's sides count alike; of a crown's leaves the inside hardly does.
    float front_share(const MapTexel& texel) const;
    void find_direct();
    /// Of surfaces that are lamps, by so many rays from the i-th on.
    glm::vec3 of_area_lamps(const MapPlace& place, float front_share, const std::vector<float>& sums, int first,
                            int rays, const glm::vec2& shift) const;
    /// False: all of that texel is inside of something.
    bool gather(std::size_t number, int rays, std::uint64_t stream, Gathered& sum) const;
    bool gather_all(int rays, std::uint64_t stream, double share);
    void find_arriving();
    double total(std::size_t layer) const;
    bool bounce_all(double share);
    bool are_beside(std::size_t one, std::size_t other, int dx, int dy) const;
    void mend_insides();
    void smooth();

    const RayScene& scene_;
    const LightMap& map_;
    std::span<const Source> sources_;
    std::span<const world::Light> lights_;
    std::vector<render::scene::LightInView> of_strength_1_;  ///< lights_ with colour 1 and intensity 1
    const TransportOptions& options_;
    BakeTeam& team_;
    AreaLamps area_lamps_;
    std::size_t glow_layer_ = 0;
    std::vector<glm::vec3> colors_;                                  ///< by texel
    std::vector<float> front_shares_;                                ///< by texel
    std::vector<std::vector<glm::vec3>> direct_, light_, arriving_;  ///< by layer and texel
    std::vector<MapPlace> places_;                                   ///< by texel: its middle
    std::vector<float> sides_m_;                                     ///< by texel
    std::vector<std::uint8_t> is_open_;                              ///< by texel: not inside of something
};

}  // namespace camrig::bake
