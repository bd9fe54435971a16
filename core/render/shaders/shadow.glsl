// Look-ups in shadow maps (core/render/shadow_plan.h).
#ifdef SHADOWS
struct ShadowMap {
    vec4 rows[4];  // texture place and depth from the optical frame of the view; w: distance from a local light, else 1
    vec4 texel;    // side of a texel: x, and y per metre of w
};
layout(std140, binding = 4) uniform ShadowBlock { ShadowMap maps[MAX_SHADOWS]; } shadows;

layout(binding = 5) uniform sampler2DArrayShadow shadow_maps;

float lit(vec3 place, float layer) { return texture(shadow_maps, vec4(place.xy, layer, place.z)); }

// Share of a light that a map lets through to `position`, whose surface has normal n there; towards: the light, unit.
float share_in_map(int map, vec3 position, vec3 n, vec3 towards) {
    vec4 row0 = shadows.maps[map].rows[0], row1 = shadows.maps[map].rows[1];
    vec4 row2 = shadows.maps[map].rows[2], row3 = shadows.maps[map].rows[3];
    vec2 texel = shadows.maps[map].texel.xy;
    // A flat surface that leans away from the light by an angle a is as deep as its neighbour in the map where it is
    // moved by sin(a) texels along its normal; the filter reaches two texels.
    float cosine = dot(n, towards);
    float side = texel.x + texel.y * max(dot(row3, vec4(position, 1.0)), 0.0);
    vec4 p = vec4(position + n * (side * (0.5 + 2.0 * sqrt(max(1.0 - cosine * cosine, 0.0)))), 1.0);
    float w = 1.0 / max(dot(row3, p), 1e-6);
    vec2 at = vec2(dot(row0, p), dot(row1, p)) * (w * SHADOW_MAP_SIDE);
    float depth = min(dot(row2, p) * w, 1.0), layer = float(map);

    // The 3x3 tent in four bilinear fetches: I. Castano, Shadow mapping summary, 2013.
    vec2 base = floor(at + 0.5);
    vec2 t = at + 0.5 - base;
    vec2 weight0 = 3.0 - 2.0 * t, weight1 = 1.0 + 2.0 * t;
    vec2 from = (base - 0.5 + (2.0 - t) / weight0 - 1.0) * (1.0 / SHADOW_MAP_SIDE);
    vec2 to = (base - 0.5 + t / weight1 + 1.0) * (1.0 / SHADOW_MAP_SIDE);
    float sum = weight0.x * weight0.y * lit(vec3(from, depth), layer) +
                weight1.x * weight0.y * lit(vec3(to.x, from.y, depth), layer) +
                weight0.x * weight1.y * lit(vec3(from.x, to.y, depth), layer) +
                weight1.x * weight1.y * lit(vec3(to, depth), layer);
    return sum * (1.0 / 16.0);
}

// Of a light with so many maps (x: the first, y: how many). Sides of a cube overlap by more than a filter reaches: of two
// that see a point one is right, and the other lacks at most what is before the point.
float lit_share(vec2 maps, vec3 position, vec3 n, vec3 towards) {
    float least = 1.0;
    for (int i = 0; i < int(maps.y); ++i) least = min(least, share_in_map(int(maps.x) + i, position, n, towards));
    return least;
}
#endif
