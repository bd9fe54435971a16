layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in vec4 in_tangent;
layout(location = 3) in vec2 in_uv0;
layout(location = 4) in vec2 in_uv1;
layout(location = 5) in vec4 in_color;
layout(location = 6) in vec2 in_light_at;

invariant gl_Position;

// Each varying costs set-up time per triangle on a CPU rasteriser, so only what the fragment shader reads exists.
#if UV_COUNT > 0
layout(location = 0) out vec2 out_uv[UV_COUNT];
#endif
#ifdef HAS_COLOR
layout(location = 5) out vec4 out_color;
#endif
#ifdef PIXEL_NORMAL
layout(location = 6) out vec3 out_normal;
#endif
#ifdef PIXEL_POSITION
layout(location = 7) out vec3 out_position;
#endif
#ifdef HAS_TANGENT
layout(location = 8) out vec4 out_tangent;
#endif
#ifdef GGX
layout(location = 12) flat out uint out_object;
#endif
#ifdef LIGHT_MAP
layout(location = 9) out vec2 out_light_at;
#endif
#if defined(SURROUNDINGS) && defined(BATCH_SIZE)
layout(location = 9) flat out int out_draw;
#endif
#ifdef VERTEX_LIGHT
layout(location = 9) out vec3 out_light;
#ifdef DOUBLE_SIDED
layout(location = 10) out vec3 out_light_behind;
#endif
#ifdef OCCLUSION_UV
layout(location = 11) out vec3 out_ambient;
#endif
#endif

vec3 rotate(vec3 v) {
    return vec3(dot(draw.position_rows[0].xyz, v), dot(draw.position_rows[1].xyz, v), dot(draw.position_rows[2].xyz, v));
}

#if UV_COUNT > 0
vec2 transformed(vec2 uv, int slot) {
    vec4 u = material.uv_rows[2 * slot];
    vec4 v = material.uv_rows[2 * slot + 1];
    return vec2(dot(u.xy, uv) + u.z, dot(v.xy, uv) + v.z);
}
#endif

void main() {
    vec3 p = rotate(in_position) +
             vec3(draw.position_rows[0].w, draw.position_rows[1].w, draw.position_rows[2].w);
    gl_Position = vec4(view.projection.x * p.x + view.projection.y * p.z, view.projection.z * p.y + view.projection.w * p.z,
                       view.depth.x * p.z + view.depth.y, p.z);
#if UV_COUNT > 0
    out_uv[0] = transformed(UV0, 0);
#endif
#if UV_COUNT > 1
    out_uv[1] = transformed(UV1, 1);
#endif
#if UV_COUNT > 2
    out_uv[2] = transformed(UV2, 2);
#endif
#if UV_COUNT > 3
    out_uv[3] = transformed(UV3, 3);
#endif
#if UV_COUNT > 4
    out_uv[4] = transformed(UV4, 4);
#endif
#ifdef HAS_COLOR
    out_color = in_color * draw.tint;
#endif
#if defined(PIXEL_NORMAL) || defined(VERTEX_LIGHT)
    vec3 n = vec3(dot(draw.normal_rows[0].xyz, in_normal), dot(draw.normal_rows[1].xyz, in_normal),
                  dot(draw.normal_rows[2].xyz, in_normal));
#endif
#ifdef PIXEL_NORMAL
    out_normal = n;
#endif
#ifdef PIXEL_POSITION
    out_position = p;
#endif
#ifdef GGX
    out_object = draw.ids.x;
#endif
#ifdef LIGHT_MAP
    out_light_at = (in_light_at + vec2(draw.ids.yz)) * view.light_map.yz;
#endif
#if defined(SURROUNDINGS) && defined(BATCH_SIZE)
    out_draw = gl_DrawIDARB;
#endif
#ifdef HAS_TANGENT
    // A mirroring turns the cross product of normal and tangent round, but not the bitangent.
    mat3 world_from_local = mat3(draw.position_rows[0].xyz, draw.position_rows[1].xyz, draw.position_rows[2].xyz);
    out_tangent = vec4(rotate(in_tangent.xyz), in_tangent.w * sign(determinant(world_from_local)));
#endif
#ifdef VERTEX_LIGHT
    n = dot(n, n) > 0.0 ? normalize(n) : vec3(0.0);  // flattened to nothing it has none
    out_light = hemisphere(n) + lambert(n, p);
#ifdef DOUBLE_SIDED
    out_light_behind = hemisphere(-n) + lambert(-n, p);
#endif
#ifdef OCCLUSION_UV
    out_ambient = hemisphere(n);
#endif
#endif
}
