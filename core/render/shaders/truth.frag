// Ground truth of the nearest surface: object number and the normal in the optical frame.
layout(location = 0) in vec3 in_normal;
#ifdef BASE_UV
layout(location = 1) in vec2 in_uv;
layout(binding = 0) uniform sampler2D base_color_texture;
#endif
#ifdef HAS_COLOR
layout(location = 2) in float in_alpha;
#endif
#ifdef BATCH_SIZE
layout(location = 3) flat in uint in_object;
#endif

layout(location = 0) out uint out_instance;
layout(location = 1) out vec4 out_normal;

void main() {
#ifdef ALPHA_MASK
    float alpha = material.base_color.a;
#ifdef BASE_UV
    alpha *= texture(base_color_texture, in_uv).a;
#endif
#ifdef HAS_COLOR
    alpha *= in_alpha;
#endif
    if (alpha < material.emissive.w) discard;
#endif
#ifdef BATCH_SIZE
    out_instance = in_object;
#else
    out_instance = draw.ids.x;
#endif
    vec3 n = dot(in_normal, in_normal) > 0.0 ? normalize(in_normal) : vec3(0.0, 0.0, -1.0);
    if (!gl_FrontFacing) n = -n;
    out_normal = vec4(dot(view.truth_rows[0].xyz, n), dot(view.truth_rows[1].xyz, n), dot(view.truth_rows[2].xyz, n), 0.0);
}
