#include "core/render/software/matched_actors.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/portable_math.h"
#include "core/base/random.h"
#include "core/render/software/mixed_pixels.h"
#include "core/render/software/rows.h"

namespace camrig::render::software {
namespace {

/// One side of a Gaussian and its middle; all of it has the sum 1.
std::vector<float> kernel_of(double sigma_px, int reach) {
    std::vector<double> weights(static_cast<std::size_t>(reach) + 1, 1.0);
    double sum = 1.0;
    for (int i = 1; i <= reach; ++i)
        sum += 2.0 * (weights[static_cast<std::size_t>(i)] = portable::exp(-0.5 * i * i / (sigma_px * sigma_px)));
    std::vector<float> kernel;
    for (const double weight : weights) kernel.push_back(static_cast<float>(weight / sum));
    return kernel;
}

/// Mean 0, variance 1, at most 3.5: the sum of four even numbers of 16 bits.
double noise_of(std::uint64_t camera, std::uint64_t instant, std::uint64_t counter) {
    const std::uint64_t bits = random_bits(camera, instant, counter);
    const auto sum =
        static_cast<double>((bits & 0xFFFF) + (bits >> 16 & 0xFFFF) + (bits >> 32 & 0xFFFF) + (bits >> 48));
    return (sum - 2.0 * 65535.0) / (65535.0 * 0.5773502691896258);
}

/// Colour times coverage, and coverage.
struct Spread {
    float red = 0.0f, green = 0.0f, blue = 0.0f, cover = 0.0f;

    void add(float weight, const Spread& other) {
        red += weight * other.red;
        green += weight * other.green;
        blue += weight * other.blue;
        cover += weight * other.cover;
    }
};

class Matcher {
public:
    Matcher(const ViewWork& work, const ViewScratch& scratch)
        : work_(work),
          scratch_(scratch),
          spec_(*work.view->spec->backdrop),
          reach_(match_reach(work)),
          kernel_(reach_ > 0 ? kernel_of(spec_.edge_px, reach_) : std::vector<float>{1.0f}) {}

    void match(const PixelRect& rect);

private:
    Spread actor_at(int x, int y) const {
        if (scratch_.actors.rows()(y)[x] == 0) return {};
        const glm::vec3 light = linear_of(scratch_.actor_colors.rows()(y)[x]);
        return {light.r, light.g, light.b, 1.0f};
    }
    /// Of a row, spread along it; false: nothing moves in it.
    bool spread_row(int y, const PixelRect& rect, std::vector<Spread>& to) const;
    std::uint32_t with_noise(std::uint32_t pixel, float cover, int x, int y) const;

    const ViewWork& work_;
    const ViewScratch& scratch_;
    const world::BackdropSpec& spec_;
    const int reach_;
    const std::vector<float> kernel_;
};

bool Matcher::spread_row(int y, const PixelRect& rect, std::vector<Spread>& to) const {
    to.assign(static_cast<std::size_t>(rect.width()), {});
    if (y < work_.whole.y0 || y >= work_.whole.y1) return false;
    const PixelRect read = common(grown(rect, reach_), work_.whole);
    const std::uint32_t* const actors = scratch_.actors.rows()(y);
    bool found = false;
    for (int x = read.x0; x < read.x1; ++x) {
        if (actors[x] == 0) continue;
        found = true;
        const Spread actor = actor_at(x, y);
        for (int i = std::max(-reach_, rect.x0 - x); i <= std::min(reach_, rect.x1 - 1 - x); ++i)
            to[static_cast<std::size_t>(x + i - rect.x0)].add(kernel_[static_cast<std::size_t>(std::abs(i))], actor);
    }
    return found;
}

std::uint32_t Matcher::with_noise(std::uint32_t pixel, float cover, int x, int y) const {
    std::uint32_t made = 0xFFu << 24;
    const auto at =
        (static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(work_.whole.x1) + static_cast<std::uint64_t>(x)) *
        3;
    for (unsigned c = 0; c < 3; ++c) {
        const double level = pixel >> 8 * c & 0xFF;
        const double sigma = cover * std::sqrt(spec_.noise->read * spec_.noise->read + spec_.noise->k * level);
        const double noise = noise_of(static_cast<std::uint64_t>(work_.view->camera),
                                      static_cast<std::uint64_t>(work_.frame->info().world_ns), at + c);
        made |= static_cast<std::uint32_t>(std::clamp(std::floor(level + sigma * noise + 0.5), 0.0, 255.0)) << 8 * c;
    }
    return made;
}

void Matcher::match(const PixelRect& rect) {
    if (rect.width() <= 0 || rect.height() <= 0) return;
    // A ring of the rows that a row of the picture is made of.
    const int rows = 2 * reach_ + 1;
    std::vector<std::vector<Spread>> ring(static_cast<std::size_t>(rows));
    std::vector<std::uint8_t> is_used(static_cast<std::size_t>(rows));
    const auto slot = [&](int y) { return static_cast<std::size_t>(((y % rows) + rows) % rows); };
    const auto take = [&](int y) { is_used[slot(y)] = spread_row(y, rect, ring[slot(y)]); };
    for (int y = rect.y0 - reach_; y < rect.y0 + reach_; ++y) take(y);
    for (int y = rect.y0; y < rect.y1; ++y) {
        take(y + reach_);
        if (std::ranges::none_of(is_used, [](std::uint8_t used) { return used != 0; })) continue;
        std::uint32_t* const out = work_.canvas.color(y);
        const std::uint32_t* const below = scratch_.below.rows()(y);
        for (int x = rect.x0; x < rect.x1; ++x) {
            Spread sum;
            for (int i = -reach_; i <= reach_; ++i)
                if (is_used[slot(y + i)] != 0)
                    sum.add(kernel_[static_cast<std::size_t>(std::abs(i))],
                            ring[slot(y + i)][static_cast<std::size_t>(x - rect.x0)]);
            if (sum.cover == 0.0f) continue;
            if (reach_ > 0) {
                const float left = std::max(0.0f, 1.0f - sum.cover);
                const glm::vec3 light = glm::vec3(sum.red, sum.green, sum.blue) + left * linear_of(below[x]);
                out[x] = srgb_code(light.r) | std::uint32_t{srgb_code(light.g)} << 8 |
                         std::uint32_t{srgb_code(light.b)} << 16 | 0xFFu << 24;
            }
            if (spec_.noise) out[x] = with_noise(out[x], std::min(1.0f, sum.cover), x, y);
        }
    }
}

}  // namespace

bool is_matched(const ViewWork& work) {
    if (work.backdrop == nullptr || work.frame == nullptr || work.has_areas) return false;
    const world::BackdropSpec& spec = *work.view->spec->backdrop;
    return spec.edge_px > 0.0 || spec.noise;
}

int match_reach(const ViewWork& work) {
    return static_cast<int>(std::ceil(3.0 * work.view->spec->backdrop->edge_px));
}

void keep_below(const ViewWork& work, ViewScratch& scratch, const PixelRect& band) {
    for (const PixelRect& rect : work.rects) {
        copy(work.canvas.color, scratch.below.rows(), common(rect, band));
        const PixelRect read = common(grown(rect, match_reach(work)), common(band, work.whole));
        if (read.width() > 0) fill(scratch.actors.rows(), read, 0u);
    }
}

void keep_where_shown(ViewScratch& scratch, const PixelRect& rect) {
    for (int y = rect.y0; y < rect.y1; ++y)
        for (int x = rect.x0; x < rect.x1; ++x)
            if (scratch.numbers.rows()(y)[x] > scratch.statics.end()) scratch.actors.rows()(y)[x] = 1;
}

void keep_colors(const ViewWork& work, ViewScratch& scratch, const PixelRect& band) {
    for (const PixelRect& rect : work.rects) copy(work.canvas.color, scratch.actor_colors.rows(), common(rect, band));
}

void match_actors(const ViewWork& work, const ViewScratch& scratch, const PixelRect& band) {
    Matcher matcher(work, scratch);
    for (const PixelRect& rect : work.rects) matcher.match(common(rect, band));
}

}  // namespace camrig::render::software
