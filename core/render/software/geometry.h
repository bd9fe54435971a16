#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/render/pixel_rect.h"
#include "core/render/software/screen_triangles.h"
#include "core/render/software/software_scene.h"
#include "core/render/view_transform.h"
#include "core/world/camera_spec.h"

/// From placed meshes to triangles on the screen: the geometry of one view.
namespace camrig {

enum TextureSlot { base_color_slot, emissive_slot, occlusion_slot, texture_slot_count };

/// What a vertex carries through a clipped edge.
struct VertexValues {
    glm::vec3 normal{0.0f};
    glm::vec4 color{1.0f};
    std::array<glm::vec2, texture_slot_count> coordinates{};
    glm::vec3 light{0.0f}, light_behind{0.0f}, ambient{0.0f};
};

/// A light as a surface in the optical frame of the view sees it. Point and spot lights in one form: a point light has
/// spot scale 0 and spot offset 1 (KHR_lights_punctual).
struct SurfaceLight {
    glm::vec3 towards{0.0f, 0.0f, -1.0f};  ///< unit, of a directional light
    glm::vec3 color{0.0f};
    glm::vec3 position{0.0f};
    glm::vec3 direction{0.0f};
    float inverse_range2 = 0.0f;
    float spot_scale = 0.0f, spot_offset = 1.0f;
};

struct SurfaceLights {
    LightSet set;
    std::vector<SurfaceLight> directional, local;
};

/// One draw of a view: where its triangles come from and how they are shaded.
struct ViewDraw {
    const SoftwareItem* item = nullptr;
    const SoftwarePrimitive* primitive = nullptr;
    const SoftwareLevel* level = nullptr;
    const glm::vec3* positions = nullptr;
    const glm::vec3* normals = nullptr;
    const glm::vec4* colors = nullptr;
    std::array<const SampledTexture*, texture_slot_count> textures{};  ///< null: none
    std::uint32_t first_vertex = 0, vertex_count = 0;                  ///< then come those made by clipping
    std::uint32_t first_clipped = 0;                                   ///< into ViewGeometry::clipped
    std::uint32_t first_triangle = 0, triangle_count = 0;
    const SurfaceLights* lights = nullptr;
    /// Quality fast: light of each vertex, into ViewGeometry::vertex_lights; -1: shaded per pixel or not at all.
    std::ptrdiff_t vertex_lights = -1;
    glm::dmat4 optical_from_local{1.0};
    glm::mat3 optical_from_normal{1.0f};
    double distance_m = 0.0;  ///< of the middle, for the order of what is blended
    std::size_t order = 0;    ///< among those at the same distance
    bool is_static = false;

    std::ptrdiff_t level_number() const { return level - primitive->levels.data(); }
};

/// What all surfaces of a view share.
struct ViewLight {
    glm::vec3 up{0.0f};                 ///< world up in the optical frame
    glm::vec3 sky{0.0f}, ground{0.0f};  ///< ambient, times the exposure
    float exposure = 1.0f;
};

struct VertexLight {
    glm::vec3 light{0.0f}, light_behind{0.0f}, ambient{0.0f};
};

/// What a view sees: its frustum, its levels of detail, its light.
struct ViewScope {
    ViewTransform transform;
    Frustum frustum;
    Quality quality = Quality::simple;
    double max_detail_error_px = 0.0;  ///< 0: every mesh in full
    bool wide_lanes = false;           ///< drawn with instructions for all lanes at once
    const Environment* environment = nullptr;
    std::span<const Light> lights;

    /// The draw of an item, if any of it may be seen; its vertices are not looked at yet.
    std::optional<ViewDraw> draw_of(const SoftwareItem& item) const;
};

/// The triangles of one view that may show a pixel, clipped, culled and snapped. Reused from view to view.
class ViewGeometry {
public:
    void begin_view(const ViewScope& scope);
    /// Adds the triangles of a draw, whose vertices are made (SoftwareItems::deform), and returns it as it is kept;
    /// good until the next one is added.
    const ViewDraw& add(ViewDraw draw, const SoftwareItems& items);

    const ViewScope& scope() const { return scope_; }
    const ViewLight& light() const { return light_; }
    std::span<const ViewDraw> draws() const { return draws_; }
    std::span<const ScreenVertex> vertices() const { return vertices_; }
    std::span<const ScreenTriangle> triangles() const { return triangles_; }
    std::span<const VertexValues> clipped() const { return clipped_; }
    std::span<const VertexLight> vertex_lights() const { return vertex_lights_; }
    PixelRect whole() const { return {0, 0, scope_.transform.size.width, scope_.transform.size.height}; }

private:
    const SurfaceLights* lights_of(const LightSet& set);
    void light_vertices(ViewDraw& draw);
    void add_triangles(const ViewDraw& draw);
    void clip(const ViewDraw& draw, const std::array<std::uint32_t, 3>& corners);
    ScreenVertex on_screen(const glm::dvec3& p) const;
    VertexValues values_of(const ViewDraw& draw, std::uint32_t vertex) const;

    ViewScope scope_;
    ViewLight light_;
    std::deque<SurfaceLights> lights_;
    std::size_t lights_used_ = 0;
    std::vector<ViewDraw> draws_;
    std::vector<ScreenVertex> vertices_;
    std::vector<std::int32_t> outside_;  ///< per vertex of the draw: which planes it is beyond
    std::vector<ScreenTriangle> triangles_;
    TriangleCorners to_clip_, made_by_clipping_;
    std::vector<VertexValues> clipped_;
    std::vector<VertexLight> vertex_lights_;
};

}  // namespace camrig
