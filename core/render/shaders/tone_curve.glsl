// PBR Neutral of the Khronos Group (2024): linear light, from 0 up, to what a picture shows of it, linear from 0 to 1.
vec3 pbr_neutral(vec3 light) {
    const float mirrored = 0.04, start = 0.8 - mirrored, rest = 1.0 - start, fading = 0.15;
    float least = min(light.r, min(light.g, light.b));
    vec3 color = light - (least < 2.0 * mirrored ? least - least * least * (0.25 / mirrored) : mirrored);
    float peak = max(color.r, max(color.g, color.b));
    if (peak < start) return color;
    float compressed = 1.0 - rest * rest / (peak + rest - start);
    return mix(vec3(compressed), color * (compressed / peak), 1.0 / (fading * (peak - compressed) + 1.0));
}
