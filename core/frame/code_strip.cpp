#include "core/frame/code_strip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "core/base/result.h"

namespace camrig::frame {
namespace {

constexpr int bit_count = code_strip_columns * code_strip_rows;
constexpr std::uint8_t sync = 0b10110010;
constexpr double min_contrast = 32;  ///< codes between black and white; below it is background, not a strip

using Bytes = std::array<std::uint8_t, bit_count / 8>;

bool bit_of(const Bytes& bytes, int bit) {
    return ((bytes[static_cast<std::size_t>(bit / 8)] >> (7 - bit % 8)) & 1) != 0;
}

/// CRC-16/CCITT-FALSE: polynomial 0x1021, start 0xffff, no reflection, no final xor; "123456789" gives 0x29b1.
std::uint16_t crc16(std::span<const std::uint8_t> bytes) {
    std::uint16_t crc = 0xffff;
    for (const std::uint8_t byte : bytes) {
        crc = static_cast<std::uint16_t>(crc ^ (byte << 8));
        for (int i = 0; i < 8; ++i) crc = static_cast<std::uint16_t>((crc & 0x8000) ? (crc << 1) ^ 0x1021 : crc << 1);
    }
    return crc;
}

template <typename T>
void put(Bytes& bytes, std::size_t at, T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i) {
        bytes[at + i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * (sizeof(T) - 1 - i)));
    }
}
template <typename T>
T get(const Bytes& bytes, std::size_t at) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) value = value << 8 | bytes[at + i];
    return static_cast<T>(value);
}

Bytes packed(const CodeStrip& strip) {
    Bytes bytes{};
    bytes[0] = sync;
    put(bytes, 1, strip.camera);
    put(bytes, 2, strip.sequence);
    put(bytes, 6, strip.world_ns);
    put(bytes, 14, crc16(std::span(bytes).first(14)));
    return bytes;
}

/// The brightness plane of a picture inside its bytes: green stands for luma, which is enough for black and white.
struct Luma {
    const std::byte* bytes;
    ImageSize size;
    int step;
    int row_bytes;

    double mean(double x0, double y0, double x1, double y1) const {
        const int left = std::clamp(static_cast<int>(std::lround(x0)), 0, size.width - 1);
        const int top = std::clamp(static_cast<int>(std::lround(y0)), 0, size.height - 1);
        const int right = std::clamp(static_cast<int>(std::lround(x1)), left + 1, size.width);
        const int bottom = std::clamp(static_cast<int>(std::lround(y1)), top + 1, size.height);
        std::int64_t sum = 0;
        for (int y = top; y < bottom; ++y) {
            for (int x = left; x < right; ++x) {
                sum += std::to_integer<int>(bytes[static_cast<std::ptrdiff_t>(y) * row_bytes + x * step]);
            }
        }
        return static_cast<double>(sum) / ((right - left) * (bottom - top));
    }
};

std::optional<Luma> luma_of(std::span<const std::byte> pixels, ImageSize size, PixelFormat format) {
    const std::byte* const p = pixels.data();
    switch (format) {
        case PixelFormat::rgba8:
            return Luma{p + 1, size, 4, 4 * size.width};
        case PixelFormat::bgr24:
        case PixelFormat::rgb24:
            return Luma{p + 1, size, 3, 3 * size.width};
        case PixelFormat::yuyv:
            return Luma{p, size, 2, (size.width + 1) / 2 * 4};
        case PixelFormat::i420:
        case PixelFormat::nv12:
        case PixelFormat::jpeg_i420:
        case PixelFormat::gray8:
            return Luma{p, size, 1, size.width};
        default:
            return std::nullopt;
    }
}

/// Reads the strip as if its cells had this side: the mean of the inner half of each cell against the middle between
/// the sync's black and white. The sync comes first, so that a wrong side costs eight cells only.
std::optional<CodeStrip> read_with_cell(const Luma& luma, double cell) {
    const auto sample = [&](int bit) {
        const double x = (bit % code_strip_columns) * cell;
        const double y = (bit / code_strip_columns) * cell;
        return luma.mean(x + cell / 4, y + cell / 4, x + cell * 3 / 4, y + cell * 3 / 4);
    };
    Bytes bytes{};
    bytes[0] = sync;
    double darkest_one = 255, brightest_zero = 0, ones = 0, zeros = 0;
    for (int bit = 0; bit < 8; ++bit) {
        const double value = sample(bit);
        if (bit_of(bytes, bit)) {
            darkest_one = std::min(darkest_one, value);
            ones += value / 4;
        } else {
            brightest_zero = std::max(brightest_zero, value);
            zeros += value / 4;
        }
    }
    const double threshold = (ones + zeros) / 2;
    if (ones - zeros < min_contrast || darkest_one <= threshold || brightest_zero >= threshold) return std::nullopt;

    for (int bit = 8; bit < bit_count; ++bit) {
        if (sample(bit) > threshold) {
            bytes[static_cast<std::size_t>(bit / 8)] |= static_cast<std::uint8_t>(1 << (7 - bit % 8));
        }
    }
    if (get<std::uint16_t>(bytes, 14) != crc16(std::span(bytes).first(14))) return std::nullopt;
    return CodeStrip{bytes[1], get<std::uint32_t>(bytes, 2), get<TimeNs>(bytes, 6)};
}

}  // namespace

int code_strip_cell(ImageSize size) {
    if (size.width < 128 || size.height < 32) return 0;
    return std::min(std::max(4, size.width / 80), size.height / code_strip_rows);
}

void draw_code_strip(std::span<std::byte> rgba, ImageSize size, const CodeStrip& strip) {
    CHECK(rgba.size() == bytes_of(PixelFormat::rgba8, size));
    const int cell = code_strip_cell(size);
    if (cell == 0) return;
    const Bytes bytes = packed(strip);
    const std::size_t row_bytes = static_cast<std::size_t>(size.width) * 4;
    for (int row = 0; row < code_strip_rows; ++row) {
        std::byte* const first = rgba.data() + static_cast<std::size_t>(row * cell) * row_bytes;
        for (int x = 0; x < code_strip_columns * cell; ++x) {
            const bool white = bit_of(bytes, row * code_strip_columns + x / cell);
            const std::byte code = white ? std::byte{255} : std::byte{0};
            std::byte* const pixel = first + static_cast<std::size_t>(x) * 4;
            pixel[0] = pixel[1] = pixel[2] = code;
            pixel[3] = std::byte{255};
        }
        const std::size_t strip_bytes = static_cast<std::size_t>(code_strip_columns * cell) * 4;
        for (int y = 1; y < cell; ++y) std::memcpy(first + static_cast<std::size_t>(y) * row_bytes, first, strip_bytes);
    }
}

std::optional<CodeStrip> read_code_strip(std::span<const std::byte> pixels, ImageSize size, PixelFormat format) {
    if (pixels.size() < bytes_of(format, size) || size.width < 64 || size.height < 8) return std::nullopt;
    const auto luma = luma_of(pixels, size, format);
    if (!luma) return std::nullopt;

    if (const int cell = code_strip_cell(size); cell > 0) {
        if (auto strip = read_with_cell(*luma, cell)) return strip;
    }
    // A scaled picture. Its cell / width is what it was before scaling: at most 1/32, and at least a bit under 1/80
    // (the integer division), or less in very flat pictures. Steps of 1/160 miss column 32 by at most 0.1 cell.
    const double largest = std::min(size.width / double{code_strip_columns}, size.height / double{code_strip_rows});
    const double smallest = std::max(1.5, size.width / 400.0);
    constexpr double step = 1 + 1.0 / 160;
    const double nominal = size.width / 80.0;
    for (double cell = nominal; cell >= smallest; cell /= step) {
        if (auto strip = read_with_cell(*luma, cell)) return strip;
    }
    for (double cell = nominal * step; cell <= largest * step; cell *= step) {
        if (auto strip = read_with_cell(*luma, cell)) return strip;
    }
    return std::nullopt;
}

}  // namespace camrig::frame
