#include "core/render/software/sampling.h"

#include "core/render/software/lanes_math.h"

namespace camrig::render::software {
namespace {

/// The two texels beside a coordinate, with the share of the second.
struct TexelPair {
    IntLanes first, second;
    Lanes share;
};

/// The texels of an image on the way from its one side to the other: as both kinds of number.
struct Texels {
    IntLanes count;
    Lanes size;
};

CAMRIG_LANES TexelPair texels_beside(Lanes coordinate, const Texels& of, world::Wrap wrap, bool is_linear) {
    Lanes at = coordinate;
    if (wrap == world::Wrap::repeat) {
        at = at - floor(at);
    } else if (wrap == world::Wrap::mirrored_repeat) {
        at = at - 2.0f * floor(at * 0.5f);
        at = at > 1.0f ? 2.0f - at : at;
    } else {
        at = clamp01(at);
    }
    const IntLanes last = of.count - 1;
    at = at * of.size - (is_linear ? 0.5f : 0.0f);
    const Lanes low = floor(at);
    IntLanes first = truncated(low), second = first + 1;
    if (wrap == world::Wrap::repeat) {
        first += of.count & (first < 0);
        first -= of.count & (first > last);
        second -= of.count & (second > last);
    }
    // With any wrap: coordinates of no number, or beyond what floor() holds, read some texel, but one of the image.
    first = min(max(first, IntLanes{}), last);
    second = min(max(second, IntLanes{}), last);
    return {first, second, is_linear ? at - low : Lanes{}};
}

/// Red and green, blue and alpha of a texel for each lane, 16 bits each.
struct TexelLanes {
    IntLanes red_green, blue_alpha;
};

/// Of a texel's channels, those from `first` up to `end`.
struct ChannelRange {
    std::size_t first, end;
    constexpr std::size_t count() const { return end - first; }
};
consteval ChannelRange range_of(TextureChannels channels) {
    switch (channels) {
        case TextureChannels::red:
            return {0, 1};
        case TextureChannels::rgb:
            return {0, 3};
        case TextureChannels::rgba:
            return {0, 4};
        case TextureChannels::alpha:
            return {3, 4};
    }
}

/// What is not wanted may be left out.
template <typename Isa, TextureChannels wanted>
CAMRIG_LANES TexelLanes texels_at(const Texel* texels, IntLanes at) {
    static_assert(sizeof(Texel) == sizeof(std::int64_t));
    const auto* const halves = reinterpret_cast<const std::int32_t*>(texels);
    if constexpr (range_of(wanted).end <= 2) {
        return {gathered<Isa>(halves, at * 2), IntLanes{}};
    } else if constexpr (range_of(wanted).first >= 2) {
        return {IntLanes{}, gathered<Isa>(halves, at * 2 + 1)};
    } else {
        // Ordered so that no shuffle has to cross the halves of a vector.
        const IntLanes order = __builtin_shufflevector(at, at, 0, 1, 4, 5, 2, 3, 6, 7);
        Words4 low, high;
        Isa::template gather<0>(reinterpret_cast<const std::int64_t*>(texels), order, low);
        Isa::template gather<1>(reinterpret_cast<const std::int64_t*>(texels), order, high);
        const auto a = reinterpret_cast<IntLanes>(low), b = reinterpret_cast<IntLanes>(high);
        return {__builtin_shufflevector(a, b, 0, 2, 8, 10, 4, 6, 12, 14),
                __builtin_shufflevector(a, b, 1, 3, 9, 11, 5, 7, 13, 15)};
    }
}

/// The texels beside each other in a row, whose places are in `columns` from `row` on.
struct TexelLanesPair {
    TexelLanes first, second;
};
template <typename Isa, TextureChannels wanted>
CAMRIG_LANES TexelLanesPair texels_of_row(const Texel* texels, IntLanes row, const TexelPair& columns,
                                          bool are_neighbors) {
    if (are_neighbors) [[likely]] {
        Quads both;
        Isa::quads(reinterpret_cast<const std::int32_t*>(texels), (row + columns.first) * 2, both);
        return {{both[0], both[1]}, {both[2], both[3]}};
    }
    return {texels_at<Isa, wanted>(texels, row + columns.first), texels_at<Isa, wanted>(texels, row + columns.second)};
}

/// Which level each lane looks at, and whether that is larger than it is seen.
struct TexelLevel {
    IntLanes number, is_magnified;
};

/// step2: the square of a step to the next pixel, in texels of the full size.
CAMRIG_LANES TexelLevel level_of(const SampledTexture& texture, Lanes step2) {
    // OpenGL 4.5, 8.14: level of detail from the longer of the two steps.
    // The exponent of the square is the level, doubled: half a level up is the next.
    const IntLanes exponent = (reinterpret_cast<IntLanes>(step2) >> 23) - 127;
    const int most = texture.sampler.mipmaps ? static_cast<int>(texture.image->levels.size()) - 1 : 0;
    const IntLanes nearest = (exponent + 1) >> 1;
    const IntLanes level = nearest < 0 ? IntLanes{} : nearest;
    // 8.14.3: from sharp to filtered at the full size; linear magnification beside a nearest mip level goes on for half
    // a level.
    const bool goes_on = texture.sampler.mipmaps && texture.sampler.minify == world::Filter::nearest;
    return {level > most ? IntLanes{} + most : level, exponent < (goes_on ? 1 : 0)};
}

/// The image of a texture that each lane looks at.
struct LevelImage {
    IntLanes first;  ///< texel
    Texels across, down;
    IntLanes is_magnified;
};

template <typename Isa>
CAMRIG_LANES LevelImage image_of(const SampledTexture& texture, const TexelLevel& level) {
    const std::vector<SoftwareImage::Level>& levels = texture.image->levels;
    static_assert(sizeof(SoftwareImage::Level) == 3 * sizeof(std::int32_t));
    const int number = level.number[0];
    IntLanes first, width, height;
    if (Isa::bits(level.number != number) == 0) [[likely]] {
        const SoftwareImage::Level& one = levels[static_cast<std::size_t>(number)];
        first = IntLanes{} + one.first;
        width = IntLanes{} + one.width;
        height = IntLanes{} + one.height;
    } else {
        // Levels follow each other in memory, each half as large (make_software_image).
        const auto halved = [&](int side) __attribute__((always_inline)) {
            return max((IntLanes{} + side) >> level.number, IntLanes{} + 1);
        };
        first = gathered<Isa>(&levels.front().first, level.number * 3);
        width = halved(levels.front().width);
        height = halved(levels.front().height);
    }
    return {first,
            {width, __builtin_convertvector(width, Lanes)},
            {height, __builtin_convertvector(height, Lanes)},
            level.is_magnified};
}

template <TextureChannels wanted>
using Sampled = std::array<Lanes, range_of(wanted).count()>;

/// These channels of a texture at (u, v). is_opaque: alpha is not looked at, and comes out as 1.
template <typename Isa, TextureChannels wanted>
CAMRIG_LANES Sampled<wanted> sample(const SampledTexture& texture, Lanes u, Lanes v, const LevelImage& of,
                                    bool is_opaque) {
    const SoftwareImage& image = *texture.image;
    const IntLanes is_magnified = of.is_magnified;
    const bool same_filter = texture.sampler.magnify == texture.sampler.minify;
    const auto pairs = [&](bool is_linear, TexelPair& columns, TexelPair& rows) __attribute__((always_inline)) {
        columns = texels_beside(u, of.across, texture.sampler.wrap_s, is_linear);
        rows = texels_beside(v, of.down, texture.sampler.wrap_t, is_linear);
    };
    TexelPair columns, rows;
    pairs(texture.sampler.minify == world::Filter::linear, columns, rows);
    if (!same_filter) {
        TexelPair large_columns, large_rows;
        pairs(texture.sampler.magnify == world::Filter::linear, large_columns, large_rows);
        const auto choose = [&](TexelPair& to, const TexelPair& large) {
            to.first = is_magnified ? large.first : to.first;
            to.second = is_magnified ? large.second : to.second;
            to.share = is_magnified ? large.share : to.share;
        };
        choose(columns, large_columns);
        choose(rows, large_rows);
    }
    const Texel* const texels = image.texels.data();
    const IntLanes upper = of.first + rows.first * of.across.count, lower = of.first + rows.second * of.across.count;
    // But where a row ends.
    const bool are_neighbors = Isa::bits(columns.second != columns.first + 1) == 0;
    const auto [a, b] = texels_of_row<Isa, wanted>(texels, upper, columns, are_neighbors);
    const auto [c, d] = texels_of_row<Isa, wanted>(texels, lower, columns, are_neighbors);
    const auto channel = [](const TexelLanes& of_texel, std::size_t i) __attribute__((always_inline)) {
        const IntLanes both = i < 2 ? of_texel.red_green : of_texel.blue_alpha;
        return __builtin_convertvector(i % 2 == 0 ? both & 0xFFFF : (both >> 16) & 0xFFFF, Lanes);
    };
    constexpr ChannelRange range = range_of(wanted);
    Sampled<wanted> made;
    for (std::size_t i = range.first; i < range.end; ++i) {
        Lanes& value = made[i - range.first];
        if (i == 3 && is_opaque) {
            value = lanes(1.0f);
            continue;
        }
        const Lanes va = channel(a, i), vb = channel(b, i), vc = channel(c, i), vd = channel(d, i);
        const Lanes above = va + (vb - va) * columns.share, below = vc + (vd - vc) * columns.share;
        value = (above + (below - above) * rows.share) * (1.0f / 65535.0f);
    }
    return made;
}

/// The mean of a texture over the footprint: up to four samples along it, at the level of its width. Decision 0105 has
/// what other numbers cost and give.
template <typename Isa, TextureChannels wanted>
CAMRIG_LANES Sampled<wanted> sample_over(const SampledTexture& texture, const TexturePoints& points, bool is_opaque) {
    // Shade, of which only red is looked at, is smooth.
    constexpr int most_samples = wanted == TextureChannels::red ? 1 : 4;
    // Where these are too few the level is as coarse as they are apart.
    const Lanes apart2 = points.longer2 * (1.0f / (most_samples * most_samples));
    // The level that is a little sharper than the width: texels are widened once more by what is filtered between them.
    constexpr float sharper2 = 0.42f;
    const TexelLevel level = level_of(texture, max(points.shorter2, apart2) * sharper2);
    const Lanes texel = reinterpret_cast<Lanes>((127 - level.number) << 23);  // 2^-level
    const Lanes length = min(sqrt(points.longer2) * texel + 0.5f, lanes(most_samples));
    const IntLanes whole = truncated(length), count = whole < 1 ? IntLanes{} + 1 : whole;
    const Lanes share = 1.0f / __builtin_convertvector(count, Lanes);
    const LevelImage image = image_of<Isa>(texture, level);
    Sampled<wanted> sum{};
    for (int i = 0; i < most_samples; ++i) {
        const IntLanes is_there = count > i;
        if (Isa::bits(is_there) == 0) break;
        const Lanes along = is_there ? (static_cast<float>(i) + 0.5f) * share - 0.5f : Lanes{};
        const auto one = sample<Isa, wanted>(texture, points.u + points.u_step * along,
                                             points.v + points.v_step * along, image, is_opaque);
        for (std::size_t c = 0; c < sum.size(); ++c) sum[c] = sum[c] + (is_there ? one[c] * share : Lanes{});
    }
    return sum;
}

/// Between the two levels beside the step to the next pixel.
template <typename Isa, TextureChannels wanted>
CAMRIG_LANES Sampled<wanted> sample_between(const SampledTexture& texture, const TexturePoints& points,
                                            bool is_opaque) {
    const auto most = static_cast<float>(texture.image->levels.size() - 1);
    // Of a normal number; what is smaller is magnified in any case.
    const Lanes detail = 0.5f * log2_of(max(points.longer2, lanes(1e-30f)));
    const Lanes at = min(max(detail, Lanes{}), lanes(most)), lower = floor(at), share = at - lower;
    TexelLevel level{truncated(lower), detail <= 0.0f};
    auto made = sample<Isa, wanted>(texture, points.u, points.v, image_of<Isa>(texture, level), is_opaque);
    if (Isa::bits(share > 0.0f) == 0) return made;
    level.number = truncated(min(lower + 1.0f, lanes(most)));
    const auto next = sample<Isa, wanted>(texture, points.u, points.v, image_of<Isa>(texture, level), is_opaque);
    for (std::size_t i = 0; i < made.size(); ++i) made[i] = made[i] + (next[i] - made[i]) * share;
    return made;
}

template <typename Isa, TextureChannels wanted>
CAMRIG_LANES void sample_into(const SampledTexture& texture, const TexturePoints& points, bool is_opaque,
                              SampledLanes& to) {
    const auto made = points.has_footprints && texture.sampler.mipmaps
                          ? sample_over<Isa, wanted>(texture, points, is_opaque)
                      : points.blends_levels
                          ? sample_between<Isa, wanted>(texture, points, is_opaque)
                          : sample<Isa, wanted>(texture, points.u, points.v,
                                                image_of<Isa>(texture, level_of(texture, points.longer2)), is_opaque);
    for (std::size_t i = 0; i < made.size(); ++i) to[range_of(wanted).first + i] = made[i];
}

template <typename Isa>
CAMRIG_LANES void sample_body(const SampledTexture& texture, const TexturePoints& points, TextureChannels channels,
                              bool is_opaque, SampledLanes& to) {
    switch (channels) {
        case TextureChannels::red:
            return sample_into<Isa, TextureChannels::red>(texture, points, is_opaque, to);
        case TextureChannels::rgb:
            return sample_into<Isa, TextureChannels::rgb>(texture, points, is_opaque, to);
        case TextureChannels::rgba:
            return sample_into<Isa, TextureChannels::rgba>(texture, points, is_opaque, to);
        case TextureChannels::alpha:
            return sample_into<Isa, TextureChannels::alpha>(texture, points, is_opaque, to);
    }
}

}  // namespace

CAMRIG_WIDE void sample_wide(const SampledTexture& texture, const TexturePoints& points, TextureChannels channels,
                             bool is_opaque, SampledLanes& to) {
    sample_body<Avx2Isa>(texture, points, channels, is_opaque, to);
}

void sample_plain(const SampledTexture& texture, const TexturePoints& points, TextureChannels channels, bool is_opaque,
                  SampledLanes& to) {
    sample_body<PlainIsa>(texture, points, channels, is_opaque, to);
}

}  // namespace camrig::render::software
