// Many samples become one pixel, in linear light: the sRGB source decodes when it is read.
#ifdef MULTISAMPLES
layout(binding = 0) uniform sampler2DMS source;
#else
layout(binding = 0) uniform sampler2D source;
#endif

layout(location = 0) out vec4 out_pixel;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 sum = vec3(0.0);
#ifdef MULTISAMPLES
    for (int i = 0; i < MULTISAMPLES; ++i) sum += texelFetch(source, pixel, i).rgb;
    sum *= 1.0 / float(MULTISAMPLES);
#else
    for (int y = 0; y < SUPERSAMPLING; ++y) {
        for (int x = 0; x < SUPERSAMPLING; ++x) {
            sum += texelFetch(source, pixel * SUPERSAMPLING + ivec2(x, y), 0).rgb;
        }
    }
    sum *= 1.0 / float(SUPERSAMPLING * SUPERSAMPLING);
#endif
    out_pixel = vec4(srgb(sum), 1.0);
}
