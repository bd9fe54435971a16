#include "core/world/backdrop/panorama.h"

#include "core/world/backdrop/scale_picture.h"

namespace camrig::world {

Result<std::shared_ptr<const Panorama>> make_panorama(Image picture) {
    constexpr int least_width = 16;
    const auto [width, height] = picture.size;
    if (width != 2 * height || width < least_width)
        return error(ErrorKind::invalid_argument,
                     "a panorama of " + picture.size.to_string() +
                         "; it shows the whole sphere, and is twice as wide as high (16x8 pixels or more)");
    auto made = std::make_shared<Panorama>();
    made->levels.push_back(std::move(picture));
    constexpr int least_height = 4;
    for (ImageSize size{width / 2, height / 2}; size.height >= least_height; size = {size.width / 2, size.height / 2})
        made->levels.push_back(scaled_picture(made->levels.back(), size));
    return made;
}

}  // namespace camrig::world
