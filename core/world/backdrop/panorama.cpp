#include "core/world/backdrop/panorama.h"

namespace camrig::world {

Result<std::shared_ptr<const Panorama>> make_panorama(Image picture) {
    constexpr int least_width = 16;
    const auto [width, height] = picture.size;
    if (width != 2 * height || width < least_width)
        return error(ErrorKind::invalid_argument,
                     "a panorama of " + picture.size.to_string() +
                         "; it shows the whole sphere, and is twice as wide as high (16x8 pixels or more)");
    return std::make_shared<const Panorama>(make_pyramid(std::move(picture)));
}

}  // namespace camrig::world
