#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/base/image_size.h"
#include "core/base/time.h"

/// A loaded glTF asset as plain, immutable data. Everything is validated by the loader: indices are in range, arrays of
/// one primitive have equal length, weights are normalised, nodes form trees. Nobody downstream checks again.
///
/// Frame: glTF's own (y up) below the roots; `world_from_gltf` (x, y, z) -> (x, -z, y) is applied once, on top of the
/// roots, by pose_model(): from there on everything is in camrig's z-up frame.
namespace camrig::world {

struct Box {
    glm::vec3 min{0.0f};
    glm::vec3 max{0.0f};
};

/// 8-bit RGBA, top row first, not premultiplied. Whether it is sRGB or linear follows from its use (glTF 2.0, 3.9).
struct Image {
    ImageSize size;
    std::vector<std::uint8_t> rgba;
};

enum class Wrap : std::uint8_t { repeat, clamp_to_edge, mirrored_repeat };
enum class Filter : std::uint8_t { nearest, linear };

struct Sampler {
    Wrap wrap_s = Wrap::repeat;
    Wrap wrap_t = Wrap::repeat;
    Filter magnify = Filter::linear;
    Filter minify = Filter::linear;
    bool mipmaps = true;
    Filter between_mipmaps = Filter::linear;
};

struct Texture {
    int image = 0;
    Sampler sampler;
};

/// Use of a texture in a material, with KHR_texture_transform folded in. texture < 0: none.
struct TextureRef {
    int texture = -1;
    int texcoord = 0;  ///< 0 or 1
    glm::vec2 offset{0.0f};
    glm::vec2 scale{1.0f};
    float rotation = 0.0f;  ///< radians, counter-clockwise as KHR_texture_transform says
};

enum class AlphaMode : std::uint8_t { opaque, mask, blend };

/// In what else a material comes (extras.camrig_variants): look_of() chooses.
struct MaterialVariants {
    std::string dye;                ///< materials of one dye have the color of one number; empty: their name's
    std::vector<glm::vec3> colors;  ///< linear; empty: none but base_color
    /// Not always there: only where the number drawn for `choice` is from `from` to below `to`. Empty: always.
    std::string choice;
    double from = 0.0, to = 1.0;
    bool is_shown = true;  ///< where no variant is asked for
};

struct Material {
    std::string name;
    glm::vec4 base_color{1.0f};  ///< linear
    TextureRef base_color_texture;
    float metallic = 1.0f;
    float roughness = 1.0f;
    TextureRef metallic_roughness_texture;
    TextureRef normal_texture;
    float normal_scale = 1.0f;
    TextureRef occlusion_texture;
    float occlusion_strength = 1.0f;
    glm::vec3 emissive{0.0f};  ///< linear
    TextureRef emissive_texture;
    AlphaMode alpha_mode = AlphaMode::opaque;
    float alpha_cutoff = 0.5f;
    bool double_sided = false;
    bool unlit = false;
    /// Glass: what it lets through goes into base_color and alpha_mode blend; what it mirrors is not thinned by alpha.
    float transmission = 0.0f;
    glm::vec3 tint{1.0f};  ///< of glass: what goes through in each colour, over the mean of the three
    MaterialVariants variants;
};

/// Strips, fans and loops are turned into lists by the loader.
enum class Topology : std::uint8_t { points, lines, triangles };

struct MorphTarget {
    std::vector<glm::vec3> positions;  ///< deltas; as many as vertices, or empty
    std::vector<glm::vec3> normals;
};

/// One draw: vertices as separate arrays, each empty or as long as `positions`.
struct Primitive {
    Topology topology = Topology::triangles;
    int material = -1;  ///< -1: the glTF default material
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;  ///< unit; made flat by the loader for triangles that have none
    std::vector<glm::vec4> tangents;
    std::vector<glm::vec2> texcoords[2];
    std::vector<glm::vec4> colors;     ///< linear RGBA
    std::vector<glm::u16vec4> joints;  ///< indices into the skin's joints
    std::vector<glm::vec4> weights;    ///< sum to 1
    std::vector<MorphTarget> targets;
    std::vector<std::uint32_t> indices;        ///< never empty
    std::vector<glm::vec2> light_coordinates;  ///< of what has baked light (BakedPrimitive); empty for all else
    Box bounds;                                ///< of the unskinned, unmorphed positions
};

struct Mesh {
    std::string name;
    std::vector<Primitive> primitives;
    std::vector<float> weights;  ///< default morph weights
};

struct Transform {
    glm::dvec3 translation{0.0};
    glm::dquat rotation{1.0, 0.0, 0.0, 0.0};
    glm::dvec3 scale{1.0};
};

struct Node {
    std::string name;
    int parent = -1;
    Transform local;
    /// Set when the file gave a matrix that is no translation * rotation * scale; then it wins and cannot be animated.
    bool has_matrix = false;
    glm::dmat4 matrix{1.0};
    int mesh = -1;
    int skin = -1;
    int camera = -1;
    int light = -1;
    std::vector<float> weights;  ///< overrides the mesh's when not empty
    std::string keypoint;        ///< extras.keypoint: the body point that the node's origin is ("left_elbow")
    std::string proxy = {};      ///< extras.camrig_proxy: what it is to a backdrop (backdrop/proxy_roles.h)
};

struct Skin {
    std::string name;
    std::vector<int> joints;  ///< node indices
    std::vector<glm::dmat4> inverse_bind;
};

enum class Interpolation : std::uint8_t { step, linear, cubic_spline };
enum class ChannelPath : std::uint8_t { translation, rotation, scale, weights };

struct Channel {
    int node = 0;
    ChannelPath path = ChannelPath::translation;
    Interpolation interpolation = Interpolation::linear;
    std::vector<TimeNs> times_ns;  ///< strictly rising, first >= 0
    std::vector<float> values;  ///< per key `width` floats (3x that for cubic splines: in-tangent, value, out-tangent)
    int width = 3;              ///< 3, 4 (rotation, xyzw) or the number of morph weights
};

struct Animation {
    std::string name;
    std::vector<Channel> channels;
    TimeNs duration_ns = 0;
    /// extras.ground_speed_m_s: how fast the ground passes under a walking clip played at speed 1; 0 when not given.
    double ground_speed_m_s = 0.0;
};

/// A camera of the file; looks along -z of its node (glTF 2.0, 3.10).
struct ModelCamera {
    std::string name;
    bool perspective = true;  ///< orthographic ones are kept for their names only
    double yfov_rad = 0.8;
    double aspect = 0.0;  ///< 0: not given
    double near_m = 0.1;
};

enum class LightType : std::uint8_t { directional, point, spot };

/// KHR_lights_punctual; shines along -z of its node.
struct ModelLight {
    std::string name;
    LightType type = LightType::point;
    glm::vec3 color{1.0f};
    float intensity = 1.0f;
    float range = 0.0f;  ///< metres; 0: unlimited
    float inner_cone_rad = 0.0f;
    float outer_cone_rad = 0.7853982f;
};

struct Model {
    std::string name;
    std::vector<Node> nodes;
    std::vector<int> order;  ///< every node of the default scene, parents before children
    std::vector<Mesh> meshes;
    std::vector<Material> materials;
    std::vector<Texture> textures;
    std::vector<Image> images;
    std::vector<Skin> skins;
    std::vector<Animation> animations;
    std::vector<ModelCamera> cameras;
    std::vector<ModelLight> lights;
    double sky_radius_m = 0.0;  ///< over 0: a sky around all else (SkyShape); rays from anywhere go through it

    /// Index of the clip of this name, or -1.
    int find_animation(std::string_view clip) const;
};

using ModelRef = std::shared_ptr<const Model>;

}  // namespace camrig::world
