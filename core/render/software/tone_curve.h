#pragma once

#include "core/render/software/lanes.h"

/// Light of more than a picture can show: core/render/shaders/tone_curve.glsl for the CPU.
namespace camrig::render::software {

/// Linear light, from 0 up, to what a picture shows of it, linear from 0 to 1: PBR Neutral of the Khronos Group (2024).
/// Up to 0.8 it takes away the 0.04 that a surface mirrors of white surroundings, so that colours are those of
/// the material; beyond, what is brightest comes near to 1 and loses colour. It can be inverted (camrig.tone).
CAMRIG_LANES Lanes3 pbr_neutral(const Lanes3& light) {
    constexpr float mirrored = 0.04f, start = 0.8f - mirrored, rest = 1.0f - start, fading = 0.15f;
    const Lanes least = min(light.x, min(light.y, light.z));
    const Lanes offset = least < 2.0f * mirrored ? least - least * least * (0.25f / mirrored) : lanes(mirrored);
    const Lanes3 color{light.x - offset, light.y - offset, light.z - offset};
    const Lanes peak = max(color.x, max(color.y, color.z));
    const Lanes compressed = 1.0f - rest * rest / (max(peak, lanes(start)) + (rest - start));
    const Lanes scale = compressed / max(peak, lanes(start));
    const Lanes share = 1.0f / (fading * (peak - compressed) + 1.0f);
    const auto part = [&](Lanes of) __attribute__((always_inline)) {
        return peak < start ? of : compressed + (of * scale - compressed) * share;
    };
    return {part(color.x), part(color.y), part(color.z)};
}

}  // namespace camrig::render::software
