// Look-ups in shadow maps (core/render/shadow_plan.h).
#ifdef SHADOWS
struct ShadowMap {
    vec4 rows[4];    // texture place and depth from the optical frame of the view; w: distance from a local light, else 1
    vec4 planes[3];  // plane_rows() of those
    vec4 texel;      // side of a texel: x, and y per metre of w
};
layout(std140, binding = 4) uniform ShadowBlock { ShadowMap maps[MAX_SHADOWS]; } shadows;

layout(binding = 5) uniform sampler2DArrayShadow shadow_maps;

// How much deeper the plane through `position` with normal n is a texel to the right, and one down.
vec2 shadow_slope(int map, vec3 position, vec3 n) {
    vec4 plane = vec4(n, -dot(n, position));
    float map_side = float(textureSize(shadow_maps, 0).x);
    vec2 across = vec2(dot(shadows.maps[map].planes[0], plane), dot(shadows.maps[map].planes[1], plane));
    return across * (-1.0 / (map_side * dot(shadows.maps[map].planes[2], plane)));
}

// Share of a light that a map lets through to `position`, whose surface has normal n there; towards: the light, unit.
float share_in_map(int map, vec3 position, vec3 n, vec3 towards) {
    vec4 row0 = shadows.maps[map].rows[0], row1 = shadows.maps[map].rows[1];
    vec4 row2 = shadows.maps[map].rows[2], row3 = shadows.maps[map].rows[3];
    vec2 texel = shadows.maps[map].texel.xy;
    float cosine = dot(n, towards), used_cosine = max(cosine, LEAST_SHADOW_COSINE);
    float side = texel.x + texel.y * max(dot(row3, vec4(position, 1.0)), 0.0);
    vec4 p = vec4(position + towards * (side * SHADOW_BIAS_TEXELS / used_cosine), 1.0);
    float w = 1.0 / max(dot(row3, p), 1e-6);
    float map_side = float(textureSize(shadow_maps, 0).x), map_texel = 1.0 / map_side;
    vec2 at = vec2(dot(row0, p), dot(row1, p)) * (w * map_side);
    float depth = dot(row2, p) * w;
    vec2 slope = shadow_slope(map, position, n + towards * (used_cosine - cosine));

    // The 3x3 tent of I. Castano, Shadow mapping summary, 2013, texel by texel: each is compared with the depth of the
    // surface's own plane there.
    vec2 base = floor(at + 0.5);
    vec2 t = at + 0.5 - base;
    vec4 right = vec4(1.0 - t.x, 2.0 - t.x, 1.0 + t.x, t.x), down = vec4(1.0 - t.y, 2.0 - t.y, 1.0 + t.y, t.y);
    float sum = 0.0;
    for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column) {
            vec2 step = vec2(column, row);
            float there = min(depth + dot(slope, step - 1.0 - t), 1.0);
            vec2 place = (base - 1.5 + step) * map_texel;
            sum += right[column] * down[row] * texture(shadow_maps, vec4(place, float(map), there));
        }
    }
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
