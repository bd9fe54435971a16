// Light from all around on a surface with normal n: from the map of baked light, from a place in the open
// (world::LightProbe), or of sky and ground.
#ifdef LIGHT_MAP
layout(location = 9) in vec2 in_light_at;
layout(binding = 8) uniform sampler2D light_map;
vec3 light_around(vec3 n) { return textureLod(light_map, in_light_at, 0.0).rgb * view.light_map.x; }
#elif defined(SURROUNDINGS)
layout(location = 9) flat in vec4 in_surroundings[3];
vec3 light_around(vec3 n) {
    vec4 at = vec4(n, 1.0);
    return max(vec3(dot(in_surroundings[0], at), dot(in_surroundings[1], at), dot(in_surroundings[2], at)), 0.0);
}
#else
vec3 light_around(vec3 n) { return hemisphere(n); }
#endif
