#include "core/frame/clock_text.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>

namespace camrig::frame {
namespace {

constexpr int glyph_width = 5, glyph_height = 7;
constexpr int text_characters = 19;  ///< with a sign

struct Glyph {
    char character;
    std::array<std::uint8_t, glyph_height> rows;  ///< from above; bit 4 is to the left
};
constexpr Glyph glyphs[] = {
    {'0', {0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110}},
    {'1', {0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110}},
    {'2', {0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111}},
    {'3', {0b11111, 0b00010, 0b00100, 0b00010, 0b00001, 0b10001, 0b01110}},
    {'4', {0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010}},
    {'5', {0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110}},
    {'6', {0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110}},
    {'7', {0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b01000, 0b01000}},
    {'8', {0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110}},
    {'9', {0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100}},
    {':', {0b00000, 0b00100, 0b00100, 0b00000, 0b00100, 0b00100, 0b00000}},
    {'.', {0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b01100, 0b01100}},
    {'-', {0b00000, 0b00000, 0b00000, 0b11111, 0b00000, 0b00000, 0b00000}},
};

int cell_of(ImageSize size) {
    return std::max(1, size.width / 320);
}

bool is_set(char character, int column, int row) {
    const auto* const glyph = std::ranges::find(glyphs, character, &Glyph::character);
    if (glyph == std::end(glyphs) || column < 0 || column >= glyph_width || row < 0 || row >= glyph_height)
        return false;
    return (glyph->rows[static_cast<std::size_t>(row)] >> (glyph_width - 1 - column) & 1) != 0;
}

}  // namespace

std::string clock_text(TimeNs time_ns) {
    // Days count downwards below 0; the time of day always runs forwards.
    constexpr TimeNs ns_per_day = 86'400 * ns_per_s;
    const TimeNs days = time_ns / ns_per_day - (time_ns % ns_per_day < 0 ? 1 : 0);
    const TimeNs ms = (time_ns - days * ns_per_day) / ns_per_ms;
    char text[48];
    std::snprintf(text, sizeof text, "%s%05lld %02d:%02d:%02d.%03d", days < 0 ? "-" : " ",
                  static_cast<long long>(days < 0 ? -days : days), static_cast<int>(ms / 3'600'000),
                  static_cast<int>(ms / 60'000 % 60), static_cast<int>(ms / 1000 % 60), static_cast<int>(ms % 1000));
    return text;
}

std::pair<int, int> clock_text_rows(ImageSize size) {
    return {std::max(0, size.height - (glyph_height + 2) * cell_of(size)), size.height};
}

void draw_clock_text(std::span<std::byte> rgba, ImageSize size, TimeNs time_ns) {
    const std::string text = clock_text(time_ns);
    const int cell = cell_of(size), first_row = clock_text_rows(size).first;
    const int end_column = std::min(size.width, (text_characters * (glyph_width + 1) + 1) * cell);
    for (int y = first_row; y < size.height; ++y)
        for (int x = 0; x < end_column; ++x) {
            const int column = x / cell - 1, row = (y - first_row) / cell - 1;
            const int index = column / (glyph_width + 1);
            const bool is_white = column >= 0 && index < static_cast<int>(text.size()) &&
                                  is_set(text[static_cast<std::size_t>(index)], column % (glyph_width + 1), row);
            std::byte* const pixel = &rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) +
                                                static_cast<std::size_t>(x))];
            std::fill_n(pixel, 3, is_white ? std::byte{255} : std::byte{0});
        }
}

}  // namespace camrig::frame
