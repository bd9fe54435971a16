layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
layout(location = 3) in vec2 in_uv0;
layout(location = 4) in vec2 in_uv1;
layout(location = 5) in vec4 in_color;

invariant gl_Position;

layout(location = 0) out vec3 out_normal;
#ifdef BASE_UV
layout(location = 1) out vec2 out_uv;
#endif
#ifdef HAS_COLOR
layout(location = 2) out float out_alpha;
#endif
#ifdef BATCH_SIZE
layout(location = 3) flat out uint out_object;
#endif

void main() {
    vec3 p = vec3(dot(draw.position_rows[0].xyz, in_position), dot(draw.position_rows[1].xyz, in_position),
                  dot(draw.position_rows[2].xyz, in_position)) +
             vec3(draw.position_rows[0].w, draw.position_rows[1].w, draw.position_rows[2].w);
    gl_Position = vec4(view.projection.x * p.x + view.projection.y * p.z, view.projection.z * p.y + view.projection.w * p.z,
                       view.depth.x * p.z + view.depth.y, p.z);
    out_normal = vec3(dot(draw.normal_rows[0].xyz, in_normal), dot(draw.normal_rows[1].xyz, in_normal),
                      dot(draw.normal_rows[2].xyz, in_normal));
#ifdef BASE_UV
    vec4 u = material.uv_rows[0], v = material.uv_rows[1];
    out_uv = vec2(dot(u.xy, UV0) + u.z, dot(v.xy, UV0) + v.z);
#endif
#ifdef HAS_COLOR
    out_alpha = in_color.a;
#endif
#ifdef BATCH_SIZE
    out_object = draw.ids.x;
#endif
}
