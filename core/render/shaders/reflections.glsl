// What reflection probes say of the light that comes along a mirrored ray (core/world/baked/reflection_probes.h,
// core/render/scene/reflections.h), as software/reflection_light.h has it.
#ifdef BAKED
layout(std140, binding = 6) uniform ReflectionBlock {
    vec4 world_rows[3];                   // world_from_optical
    vec4 gain;                            // of what the maps have; w: how many probes there are
    vec4 places[MAX_REFLECTION_PROBES];   // of the probes, in the optical frame
} reflections;
layout(std430, binding = 2) readonly buffer ReflectionTexelBlock { uint reflection_texels[]; };
layout(std430, binding = 3) readonly buffer NearnessBlock { float nearness_texels[]; };

const int reflection_starts[] = int[](REFLECTION_STARTS);  // of the levels of a probe; last: of the next probe

vec3 in_world(vec3 v) {
    return vec3(dot(reflections.world_rows[0].xyz, v), dot(reflections.world_rows[1].xyz, v),
                dot(reflections.world_rows[2].xyz, v));
}

// Of a square with a border: the first of four texels around a point, and what share the right and lower ones have.
struct SquarePlace {
    int first;
    vec2 part;
};
// world::octahedral_place() of a direction that needs no length; side: without the border.
SquarePlace square_place(vec3 direction, int side) {
    vec2 at = direction.xy / max(abs(direction.x) + abs(direction.y) + abs(direction.z), 1e-30);
    if (direction.z < 0.0)
        at = (1.0 - abs(at.yx)) * vec2(at.x < 0.0 ? -1.0 : 1.0, at.y < 0.0 ? -1.0 : 1.0);
    vec2 texel = clamp(0.5 + 0.5 * at, 0.0, 1.0) * float(side) + 0.5, corner = floor(texel);
    return SquarePlace(int(corner.y) * (side + 2) + int(corner.x), texel - corner);
}

// Of three channels with nine bits and one exponent.
vec3 reflection_texel(int index) {
    uint word = reflection_texels[index];
    return vec3(uvec3(word, word >> 9, word >> 18) & 511u) * uintBitsToFloat(((word >> 27) + (127u - 24u)) << 23);
}

vec3 level_light(int probe, int level, vec3 direction) {
    int side = REFLECTION_SIDE >> level, row = side + 2;
    SquarePlace at = square_place(direction, side);
    int first = at.first + probe * reflection_starts[REFLECTION_LEVELS] + reflection_starts[level];
    vec3 upper = mix(reflection_texel(first), reflection_texel(first + 1), at.part.x);
    vec3 lower = mix(reflection_texel(first + row), reflection_texel(first + row + 1), at.part.x);
    return mix(upper, lower, at.part.y);
}

// Metres to what a probe sees there.
float seen_distance(int probe, vec3 direction) {
    const int row = NEARNESS_SIDE + 2;
    SquarePlace at = square_place(direction, NEARNESS_SIDE);
    int first = at.first + probe * row * row;
    float upper = mix(nearness_texels[first], nearness_texels[first + 1], at.part.x);
    float lower = mix(nearness_texels[first + row], nearness_texels[first + row + 1], at.part.x);
    return 1.0 / max(mix(upper, lower, at.part.y), 1e-5) - 1.0;
}

// Light that a probe sees where a ray ends, which begins elsewhere than the probe stands: its distances say where. What
// is near is spread over less of itself than the probe, which is farther away, has it (Lagarde and de Rousiers, Moving
// Frostbite to physically based rendering, 2014).
vec3 probe_light(int probe, vec3 from_probe, vec3 ray, float roughness) {
    vec3 direction = ray;
    float farther = 1.0;
    for (int i = 0; i < 2; ++i) {
        float ray_length = max(dot(direction * seen_distance(probe, direction) - from_probe, ray), 1e-3);
        direction = from_probe + ray * ray_length;
        float inverse = inversesqrt(max(dot(direction, direction), 1e-30));
        direction *= inverse;
        farther = ray_length * inverse;
    }
    float at = min(roughness * farther / ROUGHNESS_OF_LEVEL, REFLECTION_LEVELS - 1.0);
    int level = int(min(floor(at), REFLECTION_LEVELS - 2.0));
    float rougher = at - float(level);
    return mix(level_light(probe, level, direction), level_light(probe, level + 1, direction), rougher);
}

// Light that comes along a ray from the surroundings of a position, both in the optical frame, as a surface of that
// roughness spreads it: from the two nearest probes.
vec3 light_along(vec3 position, vec3 ray, float roughness) {
    float first2 = 1e30, second2 = 1e30;
    int first = 0, second = 0;
    for (int i = 0; i < int(reflections.gain.w); ++i) {
        vec3 away = position - reflections.places[i].xyz;
        float distance2 = dot(away, away);
        if (distance2 < first2) {
            second = first;
            second2 = first2;
            first = i;
            first2 = distance2;
        } else if (distance2 < second2) {
            second = i;
            second2 = distance2;
        }
    }
    // Half of each where they are equally far, and no more of the second where it is a third further away.
    const float alone = 0.5625;
    float nearly = clamp((first2 / second2 - alone) / (1.0 - alone), 0.0, 1.0);
    float share = nearly * nearly * (1.5 - nearly);

    vec3 along = in_world(ray);
    vec3 light = probe_light(first, in_world(position - reflections.places[first].xyz), along, roughness);
    if (share > 0.0) {
        vec3 from_second = in_world(position - reflections.places[second].xyz);
        light = mix(light, probe_light(second, from_second, along, roughness), share);
    }
    return light * reflections.gain.rgb;
}

// Where images are to be seen in a surface, what it mirrors is what is there.
vec3 with_images(vec3 mirrored, vec3 position, vec3 ray, float roughness) {
    const float fading = 0.1;
    float sharp = clamp((ROUGHEST_REFLECTION - roughness) / fading, 0.0, 1.0);
    if (sharp == 0.0 || reflections.gain.w == 0.0) return mirrored;
    return mix(mirrored, light_along(position, ray, roughness), sharp);
}
#endif
