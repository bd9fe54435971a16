// Into the map of a light: DrawBlock holds the rows of clip_from_local, the last one in normal_rows.
layout(location = 0) in vec3 in_position;
layout(location = 3) in vec2 in_uv0;
layout(location = 4) in vec2 in_uv1;
layout(location = 5) in vec4 in_color;

#ifdef BASE_UV
layout(location = 1) out vec2 out_uv;
#endif
#ifdef HAS_COLOR
layout(location = 2) out float out_alpha;
#endif

void main() {
    vec4 p = vec4(in_position, 1.0);
    gl_Position = vec4(dot(draw.position_rows[0], p), dot(draw.position_rows[1], p), dot(draw.position_rows[2], p),
                       dot(draw.normal_rows[0], p));
#ifdef BASE_UV
    vec4 u = material.uv_rows[0], v = material.uv_rows[1];
    out_uv = vec2(dot(u.xy, UV0) + u.z, dot(v.xy, UV0) + v.z);
#endif
#ifdef HAS_COLOR
    out_alpha = in_color.a;
#endif
}
