#ifdef BASE_UV
layout(location = 1) in vec2 in_uv;
layout(binding = 0) uniform sampler2D base_color_texture;
#endif
#ifdef HAS_COLOR
layout(location = 2) in float in_alpha;
#endif

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
}
