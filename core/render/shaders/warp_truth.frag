// Ground truth through a lens: that of the nearest texel, never a mixture.
layout(binding = 0) uniform sampler2D depth;
layout(binding = 1) uniform isampler2D map;
#ifndef DEPTH_ONLY
layout(binding = 2) uniform usampler2D instance;
layout(binding = 3) uniform sampler2D normal;
#endif

#ifndef DEPTH_ONLY
layout(location = 0) out uint out_instance;
layout(location = 1) out vec4 out_normal;
#endif
layout(location = 2) out float out_depth;

void main() {
    ivec2 place = texelFetch(map, ivec2(gl_FragCoord.xy), 0).xy;
    bool sees = place.x != NOWHERE;
    ivec2 at = sees ? (place + 32768) >> 16 : ivec2(0);
    out_depth = sees ? texelFetch(depth, at, 0).r : 0.0;
#ifndef DEPTH_ONLY
    out_instance = sees ? texelFetch(instance, at, 0).r : 0u;
    out_normal = sees ? texelFetch(normal, at, 0) : vec4(0.0);
#endif
}
