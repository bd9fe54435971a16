#include "control/unrealcv/colors.h"

namespace camrig::unrealcv {

Rgb Colors::own_color(ObjectId object) {
    constexpr std::uint32_t levels = 32, colors = levels * levels * levels;
    std::uint32_t index = (static_cast<std::uint32_t>(object) - 1) % (colors - 1) + 1;
    // The bits of the index are dealt to the channels, coarse steps first: the first objects differ most.
    Rgb color{};
    for (std::uint32_t step = 128; step >= 8; step /= 2)
        for (std::uint8_t& channel : color) {
            if (index & 1U) channel = static_cast<std::uint8_t>(channel + step);
            index /= 2;
        }
    for (std::uint8_t& channel : color)
        if (channel != 0) channel = static_cast<std::uint8_t>(channel + 7);
    return color;
}

std::string text_of(const Rgb& color) {
    return "(R=" + std::to_string(color[0]) + ",G=" + std::to_string(color[1]) + ",B=" + std::to_string(color[2]) +
           ",A=255)";
}

}  // namespace camrig::unrealcv
