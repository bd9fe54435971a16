#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

/// Where clouds of fair weather (cumulus) stand in the sky, for who looks up from the ground: their bases are level,
/// and noise says how high they rise from there. There is one field of them, always the same, as a height over each
/// place of the ground; how much of the sky they hide is chosen. What lights them is not known here.
///
/// Any thread; the same bits on every machine.
namespace camrig::daylight {

inline constexpr double cloud_base_m = 1200.0;

/// What one direction shows of clouds.
struct CloudSight {
    std::uint8_t opacity = 0;              ///< share of the sky behind that they hide; 255: all
    std::array<std::int8_t, 3> outward{};  ///< normal of their surface, z up; 127: 1
    std::uint8_t height = 0;               ///< of what is seen, from their base (0) to the highest top (255)
    std::uint8_t depth = 0;                ///< of the cloud over it, in the same unit
};

/// All of the sky from the horizon up.
class Clouds {
public:
    static constexpr int columns = 2048, rows = 256;

    /// share: of the solid angle of the sky that clouds hide, from their lowest row up, without haze; 0 to 1.
    explicit Clouds(double share);

    /// From east (x) to the right for who looks at it.
    std::span<const CloudSight> row(int number) const;
    /// Rows below show none: that is 45 km away, within two degrees of the horizon.
    static int lowest_row();
    /// Of the middle of a row or a column. Rows are finer near the horizon, where more is seen.
    static double elevation_of(int row);
    static double pan_of(int column);

private:
    std::vector<CloudSight> sights_;
};

/// Clouds that are kept until another share is asked for. Others take tens of milliseconds, and who asks meanwhile
/// waits.
std::shared_ptr<const Clouds> clouds_of(double share);

}  // namespace camrig::daylight
