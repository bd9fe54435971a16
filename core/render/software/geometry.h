#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "core/render/pixel_rect.h"
#include "core/render/scene/scene_view.h"
#include "core/render/scene/view_lights.h"
#include "core/render/software/baked_picture.h"
#include "core/render/software/ray_triangles.h"
#include "core/render/software/screen_triangles.h"
#include "core/render/software/shadow_view.h"
#include "core/render/software/software_model.h"

/// From placed meshes to triangles on the screen: the geometry of one view.
namespace camrig::render::software {

/// What a vertex carries through a clipped edge.
struct VertexValues {
    glm::dvec3 position{0.0};  ///< in the optical frame
    glm::vec3 normal{0.0f};
    glm::vec4 color{1.0f};
    glm::vec4 tangent{0.0f};
    glm::vec3 local{0.0f};        ///< the position as of the mesh
    glm::vec3 local_ahead{0.0f};  ///< the same by ViewDraw::positions_ahead
    std::array<glm::vec2, texture_slot_count> coordinates{};
    glm::vec3 light{0.0f}, light_behind{0.0f}, ambient{0.0f};
};

/// The lights of a draw, in the optical frame of the view.
struct SurfaceLights {
    std::vector<scene::LightInView> directional, local;
    std::vector<std::span<const ShadowInView>> directional_shadows, local_shadows;  ///< the maps of each
};

/// One draw of a view: where its triangles come from and how they are shaded.
struct ViewDraw : scene::SeenSurface {
    const scene::PreparedPrimitive* primitive = nullptr;
    const scene::MeshLevel* mesh = nullptr;
    const glm::vec3* positions = nullptr;
    const glm::vec3* positions_ahead = nullptr;  ///< for flow: of a mesh that is deformed, at that time
    const glm::vec3* normals = nullptr;
    const glm::vec4* colors = nullptr;
    glm::vec4 base_color{1.0f};           ///< of its material, as its object has it
    const glm::vec4* tangents = nullptr;  ///< null: normal maps lie as their coordinates do
    std::array<const SampledTexture*, texture_slot_count> textures{};  ///< null: none
    std::uint32_t first_vertex = 0, vertex_count = 0;                  ///< then come those made by clipping
    std::uint32_t first_clipped = 0;                                   ///< into ViewGeometry::clipped
    std::uint32_t first_triangle = 0, triangle_count = 0;
    const SurfaceLights* lights = nullptr;
    /// Quality fast: light of each vertex, into ViewGeometry::vertex_lights; -1: shaded per pixel or not at all.
    std::ptrdiff_t vertex_lights = -1;
    glm::mat3 optical_from_normal{1.0f};
    glm::vec2 light_map_at{0.0f};                     ///< of its rectangle, of the map's sides
    std::optional<world::LightProbe> surroundings{};  ///< of what has no map where there is baked light
};

struct VertexLight {
    glm::vec3 light{0.0f}, light_behind{0.0f}, ambient{0.0f};
};

/// What lies between two ends of a line.
VertexValues between(const VertexValues& a, const VertexValues& b, double share);

/// The triangles of one view that may show a pixel, clipped, culled and snapped. Reused from view to view.
class ViewGeometry {
public:
    /// rays: of the view's lens, null without one. wide_lanes: drawn with instructions for all lanes at once.
    /// has_outlines: for pictures of exact areas; triangles between pixel centres are kept. shadows: of
    /// quality beautiful, as baked light.
    void begin_view(const scene::SceneView& view, std::shared_ptr<const LensRays> rays, bool wide_lanes,
                    bool has_outlines = false, std::span<const ShadowInView> shadows = {},
                    std::shared_ptr<const BakedPicture> baked = nullptr);
    /// For what a light sees: both sides of every triangle.
    void begin_shadow_map(const scene::SceneView& view, bool wide_lanes) {
        begin_view(view, nullptr, wide_lanes);
        has_both_sides_ = true;
    }
    /// Adds the triangles of a draw, whose vertices are made (PlacedSurfaces::deform), and returns it as it is kept;
    /// good until the next one is added.
    const ViewDraw& add(const scene::SeenSurface& seen, const SoftwarePrimitive& primitive,
                        const glm::vec3* positions_ahead = nullptr);

    /// Who darkens light from all around in this picture of the view; good as long as it is drawn.
    void set_bodies(const scene::BodiesInView& bodies) { bodies_ = &bodies; }
    const scene::BodiesInView* bodies() const { return bodies_; }

    const ViewTransform& transform() const { return view_.transform; }
    bool wide_lanes() const { return wide_lanes_; }
    bool has_outlines() const { return has_outlines_; }
    bool is_beautiful() const { return view_.quality == world::Quality::beautiful; }
    bool has_tone_curve() const { return view_.has_tone_curve; }
    std::span<const ShadowInView> shadows() const { return shadows_; }
    const BakedPicture* baked() const { return baked_.get(); }
    /// What a value of its map stands for.
    const glm::vec3& light_of_map() const { return light_of_map_; }
    /// Null: none, or no baked light.
    const scene::ReflectionsInView* reflections() const {
        return reflections_.maps != nullptr ? &reflections_ : nullptr;
    }
    /// Of all that is kept of the view.
    std::int64_t bytes() const;
    const scene::AmbientInView& light() const { return light_; }
    const scene::FogInView& fog() const { return fog_; }
    /// Through a lens a triangle is that of its rays, and has no place on the screen; null: no lens.
    const LensRays* rays() const { return rays_.get(); }
    std::span<const RayTriangle> ray_triangles() const { return ray_triangles_; }
    /// Depth of what is infinitely far.
    float farthest() const { return static_cast<float>(view_.transform.depth_scale); }
    std::span<const ViewDraw> draws() const { return draws_; }
    std::span<const ScreenVertex> vertices() const { return vertices_; }
    std::span<const ScreenTriangle> triangles() const { return triangles_; }
    std::span<const VertexValues> clipped() const { return clipped_; }
    std::span<const VertexLight> vertex_lights() const { return vertex_lights_; }
    PixelRect whole() const { return {0, 0, transform().size.width, transform().size.height}; }

private:
    const SurfaceLights* lights_of(int light_set);
    void light_vertices(ViewDraw& draw);
    void use_baked_light(ViewDraw& draw);
    void add_triangles(const ViewDraw& draw, const SoftwarePrimitive& primitive);
    void add_ray_triangles(const ViewDraw& draw, const TriangleRule& rule);
    void clip(const ViewDraw& draw, const std::array<std::uint32_t, 3>& corners);
    /// Appends what a point between the corners of a triangle carries.
    VertexValues& add_between(const std::array<VertexValues, 3>& values, const glm::dvec3& shares);
    ScreenVertex on_screen(const glm::dvec3& p) const;
    /// strokes.cpp: points and lines.
    struct QuadCorner {
        ScreenVertex at;
        const VertexValues* values = nullptr;
        std::int32_t dx = 0, dy = 0;
    };
    void add_strokes(const ViewDraw& draw);
    void add_point(const ViewDraw& draw, const VertexValues& point);
    void add_line(const ViewDraw& draw, const VertexValues& from, const VertexValues& to);
    void add_quad(const ViewDraw& draw, const std::array<QuadCorner, 4>& corners);
    /// The two triangles of a quad whose vertices begin there; own numbers of the draw.
    void add_halves(std::uint32_t first);
    VertexValues end_of_stroke(const ViewDraw& draw, std::uint32_t vertex) const;
    /// lens_strokes.cpp.
    void add_ray_strokes(const ViewDraw& draw, const TriangleRule& rule);
    VertexValues values_of(const ViewDraw& draw, std::uint32_t vertex) const;

    scene::SceneView view_;
    bool wide_lanes_ = false, has_outlines_ = false, has_both_sides_ = false;
    scene::AmbientInView light_;
    scene::FogInView fog_;
    std::vector<ShadowInView> shadows_;
    std::shared_ptr<const BakedPicture> baked_;  ///< of quality beautiful
    glm::vec3 light_of_map_{1.0f};
    scene::ReflectionsInView reflections_;
    const scene::BodiesInView* bodies_ = nullptr;  ///< null: nobody
    std::vector<SurfaceLights> lights_;            ///< per light set of the scene; made when first drawn with
    std::vector<bool> lights_made_;
    std::vector<ViewDraw> draws_;
    std::vector<ScreenVertex> vertices_;
    std::vector<std::int32_t> outside_;  ///< per vertex of the draw: which planes it is beyond
    std::vector<ScreenTriangle> triangles_;
    OutlineScratch outline_scratch_;
    scene::TriangleCorners to_clip_, made_by_clipping_;
    std::shared_ptr<const LensRays> rays_;
    LensNumbers lens_;
    std::vector<LensVertex> lens_vertices_;   ///< of the draw
    std::vector<RayTriangle> ray_triangles_;  ///< of triangles_
    std::vector<VertexValues> clipped_;
    std::vector<VertexLight> vertex_lights_;
};

}  // namespace camrig::render::software
