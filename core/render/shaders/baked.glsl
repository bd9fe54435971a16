// Light from all around on a surface with normal n: from the map of baked light, from a place in the open
// (world::LightProbe), or of sky and ground.
#ifdef LIGHT_MAP
layout(location = 9) in vec2 in_light_at;
layout(binding = 8) uniform sampler2D light_map;
vec3 light_around(vec3 n) { return textureLod(light_map, in_light_at, 0.0).rgb * view.light_map.x; }
#elif defined(SURROUNDINGS)
#ifdef BATCH_SIZE
layout(location = 9) flat in int in_draw;
#endif
vec3 light_around(vec3 n) {
    Surroundings s = surroundings;
    vec4 at = vec4(n, 1.0);
    vec3 light = vec3(dot(s.rows[0], at), dot(s.rows[1], at), dot(s.rows[2], at));
    light += s.products[0].rgb * (n.x * n.y) + s.products[1].rgb * (n.y * n.z) + s.products[2].rgb * (n.x * n.z);
    light += s.products[3].rgb * (n.x * n.x - n.y * n.y) + s.products[4].rgb * (3.0 * n.z * n.z - 1.0);
    return max(light, 0.0);
}
#else
vec3 light_around(vec3 n) { return hemisphere(n); }
#endif
