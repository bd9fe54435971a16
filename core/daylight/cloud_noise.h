#pragma once

#include <vector>

/// How much of a cloud wants to be over a place on the ground: fractal noise of heaps within heaps (value noise, and
/// the cellular noise of Worley, SIGGRAPH 1996, inverted), 0 to 1. It comes again every 12 km. Any thread; the same
/// bits on every machine.
namespace camrig::daylight {

class CloudNoise {
public:
    /// Takes about 50 ms.
    CloudNoise();

    /// Coordinates in metres, within 1e6 of the origin.
    float at(float x, float y) const;
    /// With lumps of about 100 m.
    float detailed_at(float x, float y) const;

private:
    std::vector<float> tile_;
};

}  // namespace camrig::daylight
