// A picture through a lens from its source (core/render/lens_plan.h). Filters are written out: places are in fixed
// point, and the weights of a GPU's texture units have 8 bits only (1/512 px). FLOAT_UNITS: those of this device are
// floats, and twice as fast. Linear light throughout: the sRGB source decodes when it is read.
layout(binding = 0) uniform sampler2D source;
layout(binding = 1) uniform isampler2D map;
#if SUPERSAMPLING > 1
layout(binding = 2) uniform sampler2D footprint;
#endif

layout(location = 0) out vec4 out_pixel;

vec3 texel(ivec2 at) { return texelFetch(source, at, 0).rgb; }

#ifdef BICUBIC
// Catmull-Rom: interpolates, reproduces quadratics.
vec4 weights(float t) {
    float t2 = t * t, t3 = t2 * t;
    return vec4(-0.5 * t3 + t2 - 0.5 * t, 1.5 * t3 - 2.5 * t2 + 1.0, -1.5 * t3 + 2.0 * t2 + 0.5 * t, 0.5 * t3 - 0.5 * t2);
}

vec3 row(ivec2 at, vec4 w) {
    return w.x * texel(at + ivec2(-1, 0)) + w.y * texel(at) + w.z * texel(at + ivec2(1, 0)) + w.w * texel(at + ivec2(2, 0));
}
#endif

vec3 filtered(ivec2 place) {
#if defined(FLOAT_UNITS) && !defined(BICUBIC)
    return textureLod(source, (vec2(place) * (1.0 / 65536.0) + 0.5) / vec2(textureSize(source, 0)), 0.0).rgb;
#else
    ivec2 at = place >> 16;
    vec2 t = vec2(place & 0xffff) * (1.0 / 65536.0);
#ifdef BICUBIC
    vec4 wx = weights(t.x), wy = weights(t.y);
    return wy.x * row(at + ivec2(0, -1), wx) + wy.y * row(at, wx) + wy.z * row(at + ivec2(0, 1), wx) +
           wy.w * row(at + ivec2(0, 2), wx);
#else
    return mix(mix(texel(at), texel(at + ivec2(1, 0)), t.x), mix(texel(at + ivec2(0, 1)), texel(at + ivec2(1, 1)), t.x), t.y);
#endif
#endif
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    ivec2 place = texelFetch(map, pixel, 0).xy;
    if (place.x == NOWHERE) {
        out_pixel = vec4(0.0, 0.0, 0.0, 1.0);
        return;
    }
#if SUPERSAMPLING > 1
    // The source has SUPERSAMPLING texels for each that the map counts; texel centres are at integers in both.
    place = (place + 32768) * SUPERSAMPLING - 32768;
    vec4 steps = texelFetch(footprint, pixel, 0) * 65536.0;
    vec3 sum = vec3(0.0);
    for (int y = 0; y < SUPERSAMPLING; ++y) {
        for (int x = 0; x < SUPERSAMPLING; ++x) {
            vec2 offset = vec2(x, y) - 0.5 * float(SUPERSAMPLING - 1);
            sum += filtered(place + ivec2(round(offset.x * steps.xy + offset.y * steps.zw)));
        }
    }
    out_pixel = vec4(srgb(sum * (1.0 / float(SUPERSAMPLING * SUPERSAMPLING))), 1.0);
#else
    out_pixel = vec4(srgb(filtered(place)), 1.0);
#endif
}
