#include "core/world/backdrop/picture_pyramid.h"

#include <algorithm>

#include "core/world/backdrop/scale_picture.h"

namespace camrig::world {

PicturePyramid make_pyramid(Image picture) {
    constexpr int least_side = 4;
    PicturePyramid made;
    ImageSize size = picture.size;
    made.levels.push_back(std::move(picture));
    for (size = {size.width / 2, size.height / 2}; std::min(size.width, size.height) >= least_side;
         size = {size.width / 2, size.height / 2})
        made.levels.push_back(scaled_picture(made.levels.back(), size));
    return made;
}

}  // namespace camrig::world
