#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/base/image_size.h"
#include "core/fault/fault_plan.h"

namespace camrig::fault {

/// How much of each pixel's light something before the lens takes, 0 to 1. What is so near is out of focus, a blurred
/// spot of a tenth of the picture and more, so a coarse grid says all of it.
class Mask {
public:
    /// Spots of a size (share of the picture's width), by the fault's seed: one field of noise above a height.
    /// `coverage` is the share of the picture where they take more than half; spots only grow with it.
    static Mask dirt(const Fault& fault, ImageSize size, double coverage, double spot);
    /// From above down to this share of the picture's height, with an edge of that width.
    static Mask from_above(ImageSize size, double share, double softness);

    /// Of a fault of the optics that hides something; nullopt: it hides nothing.
    static std::optional<Mask> of(const Fault& fault, ImageSize size);

    void row(int y, std::span<float> alpha) const;
    /// The share of the grid that is over a half.
    double covered() const;

private:
    Mask(ImageSize size, int columns, int rows);
    float& at(int column, int row) {
        return values_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                       static_cast<std::size_t>(column)];
    }

    ImageSize size_;
    int columns_ = 0, rows_ = 0;
    std::vector<float> values_;
};

/// A drop of water, in pixels.
struct WaterDrop {
    double x = 0.0, y = 0.0, radius = 0.0;
};
/// Of a fault of kind drops, by its seed: as many as its severity says of them.
std::vector<WaterDrop> drops_of(const Fault& fault, ImageSize size);

/// Whether something of the optics hides any of it.
bool hides_scene(const FrameFaults& faults);

/// How much of each pixel's light faults of the optics take or bring from elsewhere: 0: none, 255: all. A byte a pixel,
/// rows from above.
std::vector<std::uint8_t> hidden_mask(const FrameFaults* faults, ImageSize size);

/// The share of the picture's pixels of which faults of the optics hide more than half of the light.
double covered_fraction(const FrameFaults& faults, ImageSize size);

/// The radius, in pixels, of the disc that a point is blurred to by what is out of focus.
double blur_radius_px(const FrameFaults& faults, ImageSize size);

}  // namespace camrig::fault
