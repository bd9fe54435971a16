#if UV_COUNT > 0
layout(location = 0) in vec2 in_uv[UV_COUNT];
#endif
#ifdef HAS_COLOR
layout(location = 5) in vec4 in_color;
#endif
#ifdef PIXEL_NORMAL
layout(location = 6) in vec3 in_normal;
#endif
#ifdef PIXEL_POSITION
layout(location = 7) in vec3 in_position;
#endif
#ifdef HAS_TANGENT
layout(location = 8) in vec4 in_tangent;
#endif
#ifdef GGX
layout(location = 12) flat in uint in_object;
#endif
#ifdef VERTEX_LIGHT
layout(location = 9) in vec3 in_light;
#ifdef DOUBLE_SIDED
layout(location = 10) in vec3 in_light_behind;
#endif
#ifdef OCCLUSION_UV
layout(location = 11) in vec3 in_ambient;
#endif
#endif

layout(binding = 0) uniform sampler2D base_color_texture;
layout(binding = 1) uniform sampler2D emissive_texture;
layout(binding = 2) uniform sampler2D occlusion_texture;
layout(binding = 3) uniform sampler2D normal_texture;
layout(binding = 4) uniform sampler2D metallic_roughness_texture;

layout(location = 0, index = 0) out vec4 out_pixel;
#ifdef BLEND
layout(location = 0, index = 1) out vec4 out_hidden;  // of what is behind, in each colour
#endif

#if defined(PIXEL_NORMAL) && defined(NORMAL_UV)
// Tangent frame from the vertices, or from screen derivatives where they have none: t along u, b against v (which points
// down in glTF), as MikkTSpace has it, but for each triangle by itself.
vec3 mapped_normal(vec3 n) {
    vec3 m = texture(normal_texture, in_uv[NORMAL_UV]).xyz * 2.0 - 1.0;
    m.xy *= material.factors.z;
#ifdef DOUBLE_SIDED
    // The back has the whole of the front's normal turned round; n is already.
#ifdef HAS_TANGENT
    if (!gl_FrontFacing) m.x = -m.x;
#else
    if (!gl_FrontFacing) m.xy = -m.xy;
#endif
#endif
#ifdef HAS_TANGENT
    vec3 t = normalize(in_tangent.xyz - n * dot(n, in_tangent.xyz));
    vec3 b = cross(n, t) * in_tangent.w;
#else
    vec3 px = dFdx(in_position), py = dFdy(in_position);
    vec2 ux = dFdx(in_uv[NORMAL_UV]), uy = dFdy(in_uv[NORMAL_UV]);
    float turn = ux.x * uy.y - uy.x * ux.y;
    vec3 t = (uy.y * px - ux.y * py) * sign(turn);
    t -= n * dot(n, t);
    float longest = dot(t, t);
    if (longest <= 0.0) return n;  // no area in the texture
    t *= inversesqrt(longest);
    vec3 b = cross(n, t);
    if (dot(b, ux.x * py - uy.x * px) * turn > 0.0) b = -b;
#endif
    return normalize(t * m.x + b * m.y + n * m.z);
}
#endif

#ifdef GGX
layout(binding = 6) uniform sampler2D reflectance_table;
layout(binding = 7) uniform sampler2D sky_table;

// What a surface does to light, at one pixel.
struct Surface {
    vec3 normal;
    vec3 view;
    vec3 diffuse;
    vec3 f0;
    vec3 gain;  // gives back what microfacets lose among each other (Turquin 2019)
    float alpha;
};

// Of one direction, whose cosine to the normal is given.
float smith_visibility(float cosine, float a2) {
    return 1.0 / (cosine + sqrt(a2 + (1.0 - a2) * cosine * cosine));
}

// Cook-Torrance with GGX, Smith's visibility and Schlick's Fresnel over a Lambert base, times pi because Lambert's 1/pi is
// folded into the lights (glTF 2.0, appendix B).
vec3 shade_one(Surface s, vec3 l, vec3 radiance) {
    float nl = dot(s.normal, l);
    if (nl <= 0.0) return vec3(0.0);
    vec3 h = normalize(s.view + l);
    float nv = max(dot(s.normal, s.view), 1e-4), nh = max(dot(s.normal, h), 0.0), vh = max(dot(s.view, h), 0.0);
    float a2 = s.alpha * s.alpha;
    float d = nh * nh * (a2 - 1.0) + 1.0;
    float visibility = smith_visibility(nl, a2) * smith_visibility(nv, a2);
    float away = 1.0 - vh, away2 = away * away;
    vec3 fresnel = s.f0 + (1.0 - s.f0) * (away2 * away2 * away);
    return radiance * nl * (s.diffuse * (1.0 - fresnel) + fresnel * s.gain * (a2 / (d * d) * visibility));
}

float mean(vec3 v) {
    return (v.r + v.g + v.b) / 3.0;
}

// What of light from all around comes through a dielectric's surface to its base: the mean of 1 - Fresnel's share at the
// half vectors, fitted within 0.0003; as in surface_tables.h.
float share_of_base(float view_cosine) {
    float away = 1.0 - view_cosine, away2 = away * away;
    return 0.96 * (1.0 - away2 * (0.0169 + 0.0111 * away2));
}

vec2 table_place(float cosine, float roughness) {
    return vec2(cosine, roughness) * ((TABLE_SIDE - 1.0) / TABLE_SIDE) + 0.5 / TABLE_SIDE;
}
#endif

void main() {
    vec4 base = material.base_color;
#ifdef HAS_COLOR
    base *= in_color;
#endif
#ifdef BASE_UV
    base *= texture(base_color_texture, in_uv[BASE_UV]);
#endif
#ifdef ALPHA_MASK
    if (base.a < material.emissive.w) discard;
#endif

#ifdef UNLIT
    vec3 color = base.rgb * view.sky.w;
#else
    float occlusion = 1.0;
#ifdef OCCLUSION_UV
    occlusion = 1.0 + material.factors.w * (texture(occlusion_texture, in_uv[OCCLUSION_UV]).r - 1.0);
#endif

#ifdef VERTEX_LIGHT
    vec3 light = in_light;
#ifdef DOUBLE_SIDED
    if (!gl_FrontFacing) light = in_light_behind;
#endif
#ifdef OCCLUSION_UV
    vec3 ambient = in_ambient;
#ifdef DOUBLE_SIDED
    if (!gl_FrontFacing) ambient = view.sky.rgb + view.ground.rgb - in_ambient;
#endif
    light += (occlusion - 1.0) * ambient;
#endif
    vec3 color = base.rgb * light;
#else
    vec3 n = normalize(in_normal);
#ifdef DOUBLE_SIDED
    if (!gl_FrontFacing) n = -n;
#endif
#ifdef GGX
    vec3 geometric = n;
#endif
#ifdef NORMAL_UV
    n = mapped_normal(n);
#endif
#ifdef PIXEL_POSITION
    vec3 position = in_position;
#else
    vec3 position = vec3(0.0);
#endif
#ifdef GGX
    float metallic = material.factors.x, roughness = material.factors.y;
#ifdef METALLIC_ROUGHNESS_UV
    vec4 packed_factors = texture(metallic_roughness_texture, in_uv[METALLIC_ROUGHNESS_UV]);
    roughness *= packed_factors.g;
    metallic *= packed_factors.b;
#endif
    roughness = clamp(roughness, 0.0, 1.0);
    Surface s;
    s.normal = n;
    s.view = -normalize(position);
    s.alpha = max(roughness * roughness, 0.002);
    s.diffuse = base.rgb * (1.0 - metallic);
    s.f0 = mix(vec3(0.04), base.rgb, metallic);
#ifdef BLEND
    bool is_glass = material.emissive.w > 0.0;
    if (is_glass) s.diffuse *= base.a;
#endif

    // The surroundings, by the split sum: what of a uniform white world would be reflected, times what is there.
    float nv = clamp(dot(n, s.view), 0.0, 1.0);
    vec2 reflectance = textureLod(reflectance_table, table_place(nv, roughness), 0.0).rg;
    s.gain = 1.0 + s.f0 * (1.0 / (reflectance.x + reflectance.y) - 1.0);
    vec3 mirror = (s.f0 * reflectance.x + reflectance.y) * s.gain;
#ifdef BLEND
    if (is_glass) mirror *= 2.0 / (1.0 + mean(mirror));  // a pane mirrors at both of its sides
#endif
    vec3 ray = reflect(-s.view, n);
    float height = dot(ray, view.up.xyz);
    float sky = textureLod(sky_table, table_place(0.5 + 0.5 * height, roughness), 0.0).r;
    vec3 mirrored = max(mix(view.ground.rgb, view.sky.rgb, sky), 0.0);
    vec3 around = light_around(n);
#ifdef BAKED
    // As the mirror image is to the surface in the open, so it is here: but of what is dark in the open that has no bound.
    vec3 in_open = hemisphere(n);
    mirrored = around * mix(vec3(1.0), min(mirrored / max(in_open, 1e-6), 2.0), greaterThan(in_open, vec3(1e-6)));
    mirrored = with_images(mirrored, position, n, s.view, nv, roughness, mean(s.f0));
#endif
#ifdef OCCLUSION_UV
    // Lagarde and de Rousiers, Moving Frostbite to physically based rendering, 2014: what hides the sky from a surface
    // hides it from its mirror image too, the more the rougher.
    mirrored *= clamp(pow(nv + occlusion, exp2(-16.0 * roughness - 1.0)) - 1.0 + occlusion, 0.0, 1.0);
#endif
    vec3 color = s.diffuse * share_of_base(nv) * around * occlusion + mirror * mirrored;
    color *= open_share(in_object, position, geometric);
#if DIRECTIONAL_LIGHTS > 0
    for (int i = 0; i < DIRECTIONAL_LIGHTS; ++i) {
        vec3 l = lights.directional[i].towards.xyz;
        vec3 radiance = lights.directional[i].color.rgb;
#ifdef SHADOWS
        radiance *= lit_share(lights.shadow_slots[i].xy, position, geometric, l);
#endif
        color += shade_one(s, l, radiance);
    }
#endif
#if LOCAL_LIGHTS > 0
    for (int i = 0; i < LOCAL_LIGHTS; ++i) {
        vec3 l;
        vec3 radiance = local_radiance(lights.local[i], lights.local[i].position.xyz - position, l);
#ifdef SHADOWS
        radiance *= lit_share(lights.shadow_slots[DIRECTIONAL_LIGHTS + i].xy, position, geometric, l);
#endif
        color += shade_one(s, l, radiance);
    }
#endif
#else
    vec3 color = base.rgb * (hemisphere(n) * occlusion + lambert(n, position));
#endif
#endif
#endif

#ifndef UNLIT
    vec3 emissive = material.emissive.rgb * view.sky.w;
#ifdef EMISSIVE_UV
    emissive *= texture(emissive_texture, in_uv[EMISSIVE_UV]).rgb;
#endif
    color += emissive;
#endif
#ifdef GGX
    if (view.ground.w > 0.0) color = pbr_neutral(color);
#endif
#ifdef BLEND
    vec3 through = vec3(1.0);
#endif
#if defined(GGX) && defined(BLEND)
    if (is_glass) {
        // What it sends by itself is not thinned by alpha; what outshines it hides more of what lies behind.
        float most = max(color.r, max(color.g, color.b));
        base.a = clamp(max(max(1.0 - (1.0 - base.a) * (1.0 - mean(mirror)), most), 1e-3), 0.0, 1.0);
        color /= base.a;
        through = material.tint.rgb;
    }
#endif
#ifdef FOG
    color = mix(view.fog.rgb, color, exp(-view.fog.w * length(in_position)));
#endif

#ifdef BLEND
    out_pixel = vec4(clamp(color, 0.0, 1.0), base.a);  // linear: the target encodes after blending
    out_hidden = vec4(1.0 - (1.0 - base.a) * through, 1.0);
#else
    out_pixel = vec4(srgb(color), 1.0);
#endif
}
