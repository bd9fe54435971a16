// Light models shared by per-vertex and per-pixel shading.

vec3 hemisphere(vec3 n) { return mix(view.ground.rgb, view.sky.rgb, 0.5 + 0.5 * dot(n, view.up.xyz)); }

#if LOCAL_LIGHTS > 0
// Radiance of a local light at `towards` = light - surface, and its unit direction. KHR_lights_punctual.
vec3 local_radiance(LocalLight light, vec3 towards, out vec3 direction) {
    float distance2 = max(dot(towards, towards), 1e-8);
    direction = towards * inversesqrt(distance2);
    float ratio2 = distance2 * light.position.w;
    float window = clamp(1.0 - ratio2 * ratio2, 0.0, 1.0);
    float cone = clamp(-dot(direction, light.direction.xyz) * light.color.w + light.direction.w, 0.0, 1.0);
    return light.color.rgb * (window * cone * cone / distance2);
}
#endif

// Everything that reaches a Lambert surface but the ambient part.
vec3 lambert(vec3 n, vec3 position) {
    vec3 sum = vec3(0.0);
#if DIRECTIONAL_LIGHTS > 0
    for (int i = 0; i < DIRECTIONAL_LIGHTS; ++i) {
        sum += lights.directional[i].color.rgb * max(dot(n, lights.directional[i].towards.xyz), 0.0);
    }
#endif
#if LOCAL_LIGHTS > 0
    for (int i = 0; i < LOCAL_LIGHTS; ++i) {
        vec3 direction;
        vec3 radiance = local_radiance(lights.local[i], lights.local[i].position.xyz - position, direction);
        sum += radiance * max(dot(n, direction), 0.0);
    }
#endif
    return sum;
}
