#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/base/image_size.h"
#include "core/base/time.h"

namespace camrig::onvif {

/// What a camera's own analysis would say of its pictures.
struct PictureFacts {
    bool motion = false;        ///< something changed in the last hold_ns
    bool scene_change = false;  ///< most of the picture changed at once in the last hold_ns
    bool too_dark = false, too_bright = false;
    bool too_blurry = false;  ///< nowhere an edge; of a picture that is too dark nothing is said
    friend bool operator==(const PictureFacts&, const PictureFacts&) = default;
};

/// Watches the pictures of one camera as cameras do: by the mean luma (of BT.601, 0 to 255) of cells, whatever it is
/// that changes them. So a head that turns is motion too. No clock: pictures say when they are.
class PictureWatch {
public:
    static constexpr int columns = 64, rows = 36;  ///< cells; of smaller pictures, pixels
    static constexpr double change = 8.0;          ///< of a cell's mean, from one picture to the next
    static constexpr int least_cells = 2;          ///< changed, for motion
    static constexpr double most_cells = 0.6;      ///< share that has changed, for scene_change
    static constexpr TimeNs hold_ns = 2 * ns_per_s;
    static constexpr double dark = 24.0, bright = 232.0, hysteresis = 8.0;  ///< mean of the picture
    /// Levels from a pixel to the next; a picture of which less than blurry_share has such steps is blurry.
    static constexpr int edge = 12;
    static constexpr double blurry_share = 0.0005;

    /// `rgba`: size.width * size.height * 4 bytes. A picture that shows no later time than the last tells nothing new,
    /// unless it shows an earlier one: the world began anew.
    const PictureFacts& see(std::span<const std::byte> rgba, ImageSize size, TimeNs world_ns);

private:
    PictureFacts facts_;
    ImageSize size_;
    std::vector<double> cells_;
    std::optional<TimeNs> world_ns_, moved_ns_, changed_ns_;
};

}  // namespace camrig::onvif
