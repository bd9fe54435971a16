// The sRGB curve (IEC 61966-2-1) with x^(1/2.4) fitted by two square roots: at most 0.03 of a code of 255 from the
// exact curve. Much cheaper on a CPU rasteriser than pow() or an sRGB render target.
vec3 srgb(vec3 c) {
    c = clamp(c, 0.0, 1.0);
    vec3 root = sqrt(c);
    vec3 high = 0.91269030 * root + 0.25450221 * sqrt(root) + c * (0.03564411 * root - 0.13222371) - 0.07051239;
    return mix(high, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}
