// Uniform blocks, mirrored by gl/uniform_blocks.h. Positions, normals and lights are all in the optical frame of the
// view (x right, y down, z forward); colours are linear and already multiplied by the exposure.

layout(std140, binding = 0) uniform ViewBlock {
    vec4 projection;  // x_scale, x_shift, y_scale, y_shift
    vec4 depth;       // depth_scale, depth_shift
    vec4 up;          // world up
    vec4 sky;         // ambient from above; w: exposure
    vec4 ground;      // ambient from below; w: 1 where there is a tone curve
    vec4 fog;         // its colour; w: how much of it comes per metre
    vec4 bodies;      // x: how many there are (contact.glsl)
    vec4 light_map;   // x: light of a full code of the map of baked light; yz: 1 / its width and height in texels
    vec4 truth_rows[3];  // the frame that true normals are given in, from this view's
} view;

struct Draw {
    vec4 position_rows[3];  // optical_from_local
    vec4 normal_rows[3];    // its cofactor matrix, times the sign of the determinant
    uvec4 ids;              // x: object; yz: where its rectangle begins in the map of baked light, in texels
    vec4 tint;              // of the base color, where there are vertex colors
};
#ifdef BATCH_SIZE
layout(std140, binding = 1) uniform DrawBlocks { Draw draws[BATCH_SIZE]; };
#define draw draws[gl_DrawIDARB]  // in vertex shaders
#else
layout(std140, binding = 1) uniform DrawBlock { Draw draw; };
#endif

// Light from all around at a place: on a surface with normal n, each channel is the dot product of its row and (n, 1),
// plus each of `products` times that of world::products_of(n).
#ifdef SURROUNDINGS
struct Surroundings {
    vec4 rows[3];
    vec4 products[5];
};
#ifdef BATCH_SIZE
layout(std140, binding = 5) uniform SurroundingsBlocks { Surroundings surroundings_of_draws[BATCH_SIZE]; };
#define surroundings surroundings_of_draws[in_draw]  // in fragment shaders
#else
layout(std140, binding = 5) uniform SurroundingsBlock { Surroundings surroundings; };
#endif
#endif

#define MAX_UV 5
layout(std140, binding = 2) uniform MaterialBlock {
    vec4 base_color;
    vec4 emissive;         // w: alpha cutoff; of what is blended, its transmission
    vec4 factors;          // metallic, roughness, normal scale, occlusion strength
    vec4 tint;             // of glass: of what goes through
    vec4 uv_rows[2 * MAX_UV];  // per used texture coordinate: KHR_texture_transform as two affine rows
} material;

#if DIRECTIONAL_LIGHTS > 0 || LOCAL_LIGHTS > 0
struct DirectionalLight {
    vec4 towards;  // unit, towards the light
    vec4 color;
};
// Point and spot lights in one form: a point light has spot scale 0 and spot offset 1.
struct LocalLight {
    vec4 position;   // w: 1 / range^2, 0 without a range
    vec4 color;      // w: spot scale
    vec4 direction;  // the way it shines; w: spot offset
};
layout(std140, binding = 3) uniform LightBlock {
#if DIRECTIONAL_LIGHTS > 0
    DirectionalLight directional[DIRECTIONAL_LIGHTS];
#endif
#if LOCAL_LIGHTS > 0
    LocalLight local[LOCAL_LIGHTS];
#endif
#ifdef SHADOWS
    vec4 shadow_slots[DIRECTIONAL_LIGHTS + LOCAL_LIGHTS];  // into shadows.maps, x: the first, y: how many
#endif
} lights;
#endif
