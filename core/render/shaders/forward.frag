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
#ifdef VERTEX_LIGHT
layout(location = 9) in vec3 in_light;
#ifdef DOUBLE_SIDED
layout(location = 10) in vec3 in_light_behind;
#endif
#endif

layout(binding = 0) uniform sampler2D base_color_texture;
layout(binding = 1) uniform sampler2D emissive_texture;
layout(binding = 2) uniform sampler2D occlusion_texture;
layout(binding = 3) uniform sampler2D normal_texture;
layout(binding = 4) uniform sampler2D metallic_roughness_texture;

layout(location = 0) out vec4 out_pixel;

#if defined(PIXEL_NORMAL) && defined(NORMAL_UV)
// Tangent frame from the vertices, or from screen derivatives where the file has no tangents.
vec3 mapped_normal(vec3 n) {
    vec3 m = texture(normal_texture, in_uv[NORMAL_UV]).xyz * 2.0 - 1.0;
    m.xy *= material.factors.z;
#ifdef HAS_TANGENT
    vec3 t = normalize(in_tangent.xyz - n * dot(n, in_tangent.xyz));
    vec3 b = cross(n, t) * in_tangent.w;
#else
    vec3 px = dFdx(in_position), py = dFdy(in_position);
    vec2 ux = dFdx(in_uv[NORMAL_UV]), uy = dFdy(in_uv[NORMAL_UV]);
    vec3 along_u = cross(py, n) * ux.x + cross(n, px) * uy.x;
    vec3 along_v = cross(py, n) * ux.y + cross(n, px) * uy.y;
    float longest = max(max(dot(along_u, along_u), dot(along_v, along_v)), 1e-20);
    vec3 t = along_u * inversesqrt(longest);
    vec3 b = along_v * inversesqrt(longest);
#endif
    return normalize(t * m.x + b * m.y + n * m.z);
}
#endif

#ifdef GGX
// Cook-Torrance with GGX and Smith-Schlick visibility, times pi because Lambert's 1/pi is folded into the lights.
vec3 ggx(vec3 n, vec3 v, vec3 l, float alpha, vec3 f0) {
    vec3 h = normalize(v + l);
    float nl = max(dot(n, l), 0.0), nv = max(dot(n, v), 1e-4), nh = max(dot(n, h), 0.0), vh = max(dot(v, h), 0.0);
    float a2 = alpha * alpha;
    float d = nh * nh * (a2 - 1.0) + 1.0;
    float k = 0.5 * alpha;
    float visibility = 0.25 / ((nl * (1.0 - k) + k) * (nv * (1.0 - k) + k));
    vec3 fresnel = f0 + (1.0 - f0) * pow(1.0 - vh, 5.0);
    return fresnel * (a2 / (d * d) * visibility);
}

vec3 shade_one(vec3 n, vec3 v, vec3 l, vec3 radiance, vec3 diffuse, vec3 f0, float alpha) {
    return radiance * max(dot(n, l), 0.0) * (diffuse + ggx(n, v, l, alpha, f0));
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
#ifdef DOUBLE_SIDED
    vec3 color = base.rgb * (gl_FrontFacing ? in_light : in_light_behind);
#else
    vec3 color = base.rgb * in_light;
#endif
#else
    vec3 n = normalize(in_normal);
#ifdef DOUBLE_SIDED
    if (!gl_FrontFacing) n = -n;
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
    float alpha = max(roughness * roughness, 0.002);
    vec3 diffuse = base.rgb * (1.0 - metallic);
    vec3 f0 = mix(vec3(0.04), base.rgb, metallic);
    vec3 v = -normalize(position);
    // Without an image of the surroundings a metal mirrors the hemisphere in its own colour.
    vec3 color = (diffuse * hemisphere(n) + base.rgb * metallic * hemisphere(reflect(-v, n))) * occlusion;
#if DIRECTIONAL_LIGHTS > 0
    for (int i = 0; i < DIRECTIONAL_LIGHTS; ++i) {
        color += shade_one(n, v, lights.directional[i].towards.xyz, lights.directional[i].color.rgb, diffuse, f0, alpha);
    }
#endif
#if LOCAL_LIGHTS > 0
    for (int i = 0; i < LOCAL_LIGHTS; ++i) {
        vec3 l;
        vec3 radiance = local_radiance(lights.local[i], lights.local[i].position.xyz - position, l);
        color += shade_one(n, v, l, radiance, diffuse, f0, alpha);
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

#ifdef BLEND
    out_pixel = vec4(clamp(color, 0.0, 1.0), base.a);  // linear: the target encodes after blending
#else
    out_pixel = vec4(srgb(color), 1.0);
#endif
}
