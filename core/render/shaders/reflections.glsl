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

// Of the levels of a probe; the last one is a mirror's.
const int reflection_starts[] = int[](REFLECTION_STARTS), reflection_sides[] = int[](REFLECTION_SIDES);
const float reflection_roughness[] = float[](REFLECTION_ROUGHNESS);

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
    int side = reflection_sides[level], row = side + 2;
    SquarePlace at = square_place(direction, side);
    int first = at.first + probe * reflection_starts[MIRROR_LEVEL] + min(probe, MOST_MIRROR_PROBES) * TEXELS_OF_MIRROR +
                reflection_starts[level];
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

// The light of a level between two of them. roughness: of the surface, which says whether it is a mirror; spread: as
// rough as what it mirrors looks.
vec3 light_between_levels(int probe, vec3 direction, float roughness, float spread) {
    int lower = MIRROR_LEVEL, upper = 0;
    float part = clamp(spread / reflection_roughness[0], 0.0, 1.0);
    if (roughness >= reflection_roughness[0]) {
        float first = reflection_roughness[0], second = reflection_roughness[1], third = reflection_roughness[2];
        float at = max(min((spread - first) / (second - first), min((spread - second) / (third - second) + 1.0, 2.0)), 0.0);
        lower = at >= 1.0 ? 1 : 0;
        upper = lower + 1;
        part = at - float(lower);
    }
    return mix(level_light(probe, lower, direction), level_light(probe, upper, direction), part);
}

// The ways that a surface looks at what it mirrors, each with its weight.
const int reflection_looks = 3;
struct Looks {
    vec3 ways[reflection_looks];  // world
    float weights[reflection_looks];
    float across;  // how rough the image looks across these
};

// Light that a probe sees along ways that begin elsewhere than it stands: its distances say where the first one ends.
// What is near is spread over less of itself than the probe, which is farther away, has it (Lagarde and de Rousiers,
// Moving Frostbite to physically based rendering, 2014).
vec3 probe_light(int probe, vec3 from_probe, Looks looks, float roughness) {
    vec3 ray = looks.ways[0], direction = ray;
    float farther = 1.0;
    for (int i = 0; i < 2; ++i) {
        float ray_length = max(dot(direction * seen_distance(probe, direction) - from_probe, ray), 1e-3);
        direction = from_probe + ray * ray_length;
        float inverse = inversesqrt(max(dot(direction, direction), 1e-30));
        direction *= inverse;
        farther = ray_length * inverse;
    }
    vec3 light = vec3(0.0);
    for (int i = 0; i < reflection_looks; ++i) {
        if (looks.weights[i] == 0.0) continue;
        vec3 way = direction + (looks.ways[i] - ray) * farther;
        light += light_between_levels(probe, way, roughness, looks.across * farther) * looks.weights[i];
    }
    return light;
}

float smith_masking(float cosine, float alpha2) {
    float cosine2 = cosine * cosine;
    return 0.5 * sqrt(1.0 + alpha2 * (1.0 - cosine2) / cosine2);  // and a half
}

// As software/reflection_light.h has it.
Looks looks_of(vec3 normal, vec3 view, float cosine, float roughness, float f0) {
    const float least_cosine = 0.02;
    const float halves[] = float[](0.0, 0.76, -0.76);
    float alpha = roughness * roughness, alpha2 = alpha * alpha;
    float z = max(cosine, least_cosine), x = sqrt(max(1.0 - z * z, 0.0));
    vec3 aside = view - normal * dot(normal, view);
    vec3 axis = aside * inversesqrt(max(dot(aside, aside), 1e-12));
    bool is_mirror = roughness < reflection_roughness[0];
    Looks looks;
    float sum = 0.0;
    for (int i = 0; i < reflection_looks; ++i) {
        float turned = alpha * x * halves[i], half_z = inversesqrt(1.0 + turned * turned), half_x = turned * half_z;
        float across = x * half_x + z * half_z;
        float way_x = 2.0 * across * half_x - x, way_z = 2.0 * across * half_z - z;
        float fresnel = f0 + (1.0 - f0) * pow(1.0 - clamp(across, 0.0, 1.0), 5.0);
        float weight = fresnel * across / (smith_masking(z, alpha2) + smith_masking(max(way_z, least_cosine), alpha2));
        looks.weights[i] = across > 0.0 && way_z > 0.0 && (i == 0 || !is_mirror) ? weight : 0.0;
        sum += looks.weights[i];
        looks.ways[i] = in_world(axis * way_x + normal * max(way_z, least_cosine));
    }
    for (int i = 0; i < reflection_looks; ++i) looks.weights[i] /= max(sum, 1e-9);
    looks.across = sqrt(alpha * z);
    return looks;
}

// Light that a surface mirrors, in the optical frame, from the two nearest probes.
vec3 mirrored_light(vec3 position, vec3 normal, vec3 view, float cosine, float roughness, float f0) {
    float first2 = 1e30, second2 = 1e30;
    int first = 0, second = 0;
    int count = int(reflections.gain.w);
    if (roughness < reflection_roughness[0]) count = min(count, MOST_MIRROR_PROBES);
    for (int i = 0; i < count; ++i) {
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
    // Half of each where they are equally far, and no more of the second where it is a sixth further away.
    const float alone = 0.7225;
    float nearly = clamp((first2 / second2 - alone) / (1.0 - alone), 0.0, 1.0);
    float share = nearly * nearly * (1.5 - nearly);

    Looks looks = looks_of(normal, view, cosine, roughness, f0);
    vec3 light = probe_light(first, in_world(position - reflections.places[first].xyz), looks, roughness);
    if (share > 0.0) {
        vec3 from_second = in_world(position - reflections.places[second].xyz);
        light = mix(light, probe_light(second, from_second, looks, roughness), share);
    }
    return light * reflections.gain.rgb;
}

// Where images are to be seen in a surface, what it mirrors is what is there.
vec3 with_images(vec3 mirrored, vec3 position, vec3 normal, vec3 view, float cosine, float roughness, float f0) {
    const float fading = 0.1, roughest = reflection_roughness[MIRROR_LEVEL - 1];
    float sharp = clamp((roughest - roughness) / fading, 0.0, 1.0);
    if (sharp == 0.0 || reflections.gain.w == 0.0) return mirrored;
    return mix(mirrored, mirrored_light(position, normal, view, cosine, roughness, f0), sharp);
}
#endif
