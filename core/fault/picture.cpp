#include "core/fault/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/portable_math.h"
#include "core/base/random.h"
#include "core/fault/light.h"
#include "core/fault/mask.h"

namespace camrig::fault {
namespace {

int byte_of(double value) {
    return std::clamp(static_cast<int>(std::floor(value + 0.5)), 0, 255);
}

/// Three colour bytes, each by a table of its own.
using Tables = std::array<std::array<std::byte, 256>, 3>;

template <typename Function>
std::array<std::byte, 256> table_of(Function function) {
    std::array<std::byte, 256> table{};
    for (int i = 0; i < 256; ++i) table[static_cast<std::size_t>(i)] = static_cast<std::byte>(function(i));
    return table;
}

void map_bytes(std::span<std::byte> rgba, const Tables& tables) {
    for (std::size_t i = 0; i + 3 < rgba.size(); i += 4)
        for (std::size_t c = 0; c < 3; ++c) rgba[i + c] = tables[c][std::to_integer<std::size_t>(rgba[i + c])];
}

std::array<std::byte, 256> light_table(double factor) {
    return table_of([factor](int value) { return coded(factor * light_of(value)); });
}

struct Change {
    const Fault& fault;
    const FrameKey& frame;
    ImageSize size;
    std::span<std::byte> rgba;

    std::byte* pixel(int x, int y) const {
        return &rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) +
                          static_cast<std::size_t>(x))];
    }
    void set(int x, int y, std::byte value) const { std::fill_n(pixel(x, y), 3, value); }

    /// Light of a colour in front of the picture, where the mask says how much.
    void veil(const Mask& mask, std::array<double, 3> color) const {
        std::vector<float> row(static_cast<std::size_t>(size.width));
        for (int y = 0; y < size.height; ++y) {
            mask.row(y, row);
            for (int x = 0; x < size.width; ++x) {
                const double alpha = row[static_cast<std::size_t>(x)];
                if (alpha <= 0.0) continue;
                std::byte* const at = pixel(x, y);
                for (std::size_t c = 0; c < 3; ++c)
                    at[c] = static_cast<std::byte>(
                        coded((1.0 - alpha) * light_of(std::to_integer<int>(at[c])) + alpha * color[c]));
            }
        }
    }

    void operator()(const Defocus& defocus) const { blur(rgba, size, defocus.radius * fault.severity * size.width); }
    void operator()(const Dirt& dirt) const { veil(*Mask::of(fault, size), {dirt.red, dirt.green, dirt.blue}); }
    void operator()(const WaterDrops&) const {
        const std::vector<std::byte> behind(rgba.begin(), rgba.end());
        for (const WaterDrop& drop : drops_of(fault, size)) {
            const int top = std::max(0, static_cast<int>(drop.y - drop.radius)),
                      bottom = std::min(size.height - 1, static_cast<int>(drop.y + drop.radius) + 1);
            const int left = std::max(0, static_cast<int>(drop.x - drop.radius)),
                      right = std::min(size.width - 1, static_cast<int>(drop.x + drop.radius) + 1);
            for (int y = top; y <= bottom; ++y)
                for (int x = left; x <= right; ++x) {
                    const double dx = (x - drop.x) / drop.radius, dy = (y - drop.y) / drop.radius;
                    const double away = dx * dx + dy * dy;
                    if (away >= 1.0) continue;
                    // A ball lens shows half of the picture's width, upside down, and less light at its rim.
                    const double reach = 0.25 * size.width, light = 1.0 - 0.6 * away * away;
                    const int from_x = std::clamp(static_cast<int>(drop.x - reach * dx), 0, size.width - 1);
                    const int from_y = std::clamp(static_cast<int>(drop.y - reach * dy), 0, size.height - 1);
                    const std::byte* const from =
                        &behind[4 * (static_cast<std::size_t>(from_y) * static_cast<std::size_t>(size.width) +
                                     static_cast<std::size_t>(from_x))];
                    std::byte* const to = pixel(x, y);
                    for (std::size_t c = 0; c < 3; ++c)
                        to[c] = static_cast<std::byte>(coded(light * light_of(std::to_integer<int>(from[c]))));
                }
        }
    }
    void operator()(const Condensation& fog) const {
        blur(rgba, size, fog.radius * fault.severity * size.width);
        const double veil = fog.veil * fault.severity;
        const auto table = table_of([veil](int value) { return coded((1.0 - veil) * light_of(value) + veil * 0.4); });
        map_bytes(rgba, {table, table, table});
    }
    void operator()(const Covered&) const { veil(*Mask::of(fault, size), {0.002, 0.002, 0.002}); }
    void operator()(const Exposure& exposure) const {
        const auto table = light_table(1.0 + fault.severity * (exposure.factor - 1.0));
        map_bytes(rgba, {table, table, table});
    }
    void operator()(const WhiteBalance& balance) const {
        map_bytes(rgba, {light_table(1.0 + fault.severity * (balance.red - 1.0)), light_table(1.0),
                         light_table(1.0 + fault.severity * (balance.blue - 1.0))});
    }
    void operator()(const ChromaLost&) const {
        for (std::size_t i = 0; i + 3 < rgba.size(); i += 4) {
            const auto code = [&](std::size_t c) { return std::to_integer<int>(rgba[i + c]); };
            const double luma = 0.299 * code(0) + 0.587 * code(1) + 0.114 * code(2);  // ITU-R BT.601
            for (std::size_t c = 0; c < 3; ++c)
                rgba[i + c] = static_cast<std::byte>(byte_of(code(c) + fault.severity * (luma - code(c))));
        }
    }
    void operator()(const Noise& noise) const {
        // The sum of eight even numbers of 8 bits has a standard deviation of sqrt(8 * (256^2 - 1) / 12) = 209.0.
        const double scale = fault.severity * noise.deviation * 255.0 / 209.0;
        const std::uint64_t key = random_bits(fault.seed, fault.id, static_cast<std::uint64_t>(frame.sequence));
        for (std::size_t i = 0; i < rgba.size(); ++i) {
            if (i % 4 == 3) continue;
            const int sum = byte_sum(mixed(key + i)) - 1020;
            rgba[i] = static_cast<std::byte>(byte_of(std::to_integer<int>(rgba[i]) + scale * sum));
        }
    }
    void operator()(const Banding& banding) const {
        const double at_s = static_cast<double>(frame.world_ns - fault.begin_ns) * 1e-9;
        for (int y = 0; y < size.height; ++y) {
            const double turns = banding.bands * y / size.height + banding.drift_hz * at_s;
            const auto table = light_table(1.0 - fault.severity * banding.depth *
                                                     (0.5 + 0.5 * portable::cos(2.0 * std::numbers::pi * turns)));
            const std::size_t bytes = 4 * static_cast<std::size_t>(size.width);
            map_bytes(rgba.subspan(static_cast<std::size_t>(y) * bytes, bytes), {table, table, table});
        }
    }
    void operator()(const DeadPixels& dead) const {
        const std::uint64_t key = mixed(fault.seed + mixed(fault.id));
        const double chosen = std::ldexp(dead.share * fault.severity, 64);
        for (std::size_t at = 0; at < static_cast<std::size_t>(size.pixels()); ++at) {
            const std::uint64_t bits = mixed(key + at);
            if (static_cast<double>(bits) < chosen) std::fill_n(&rgba[4 * at], 3, std::byte(bits % 2 == 0 ? 0 : 255));
        }
    }
    void operator()(const DeadRows& dead) const {
        const int lines = dead.columns ? size.width : size.height;
        for (int line = 0; line < lines; ++line) {
            if (chance(fault, static_cast<std::uint64_t>(line)) >= dead.share * fault.severity) continue;
            const std::byte value{chance(fault, static_cast<std::uint64_t>(line), 1) < 0.5 ? std::uint8_t{0}
                                                                                           : std::uint8_t{255}};
            for (int i = 0; i < (dead.columns ? size.height : size.width); ++i)
                dead.columns ? set(line, i, value) : set(i, line, value);
        }
    }
    void operator()(const Mirrored&) const {
        for (int y = 0; y < size.height; ++y)
            for (int x = 0; x < size.width / 2; ++x)
                std::swap_ranges(pixel(x, y), pixel(x, y) + 4, pixel(size.width - 1 - x, y));
    }
    void operator()(const UpsideDown&) const {
        const std::size_t pixels = rgba.size() / 4;
        for (std::size_t i = 0; i < pixels / 2; ++i)
            std::swap_ranges(&rgba[4 * i], &rgba[4 * i] + 4, &rgba[4 * (pixels - 1 - i)]);
    }
    void operator()(const Black&) const {
        const auto table = table_of([keeps = 1.0 - fault.severity](int value) { return byte_of(keeps * value); });
        map_bytes(rgba, {table, table, table});
    }
    void operator()(const auto&) const {}
};

bool is_of_picture(const FaultRef& fault) {
    const Layer layer = layer_of(fault->kind);
    return layer == Layer::optics || layer == Layer::sensor;
}

}  // namespace

bool changes_picture(const FrameFaults& faults) {
    return std::ranges::any_of(faults.active, is_of_picture);
}

int torn_rows(const FrameFaults& faults, int height) {
    int rows = 0;
    for (const FaultRef& one : faults.active)
        if (const auto* const torn = std::get_if<Tearing>(&one->kind))
            rows = std::max(rows, static_cast<int>(std::lround(torn->share * one->severity * height)));
    return rows;
}

bool hides_picture(const FrameFaults& faults) {
    return std::ranges::any_of(faults.active, [](const FaultRef& one) {
        return std::holds_alternative<Black>(one->kind) && one->severity >= 1.0;
    });
}

void change_picture(const FrameFaults& faults, ImageSize size, std::span<std::byte> rgba) {
    for (const FaultRef& one : faults.active) std::visit(Change{*one, faults.frame, size, rgba}, one->kind);
}

}  // namespace camrig::fault
