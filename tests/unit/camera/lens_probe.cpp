// Not a test: undistorts points for the accuracy report, which compares the answers with OpenCV's.
//
//     lens_probe < INPUT > OUTPUT      INPUT: lines of MODEL K1 ... KN X Y (distorted plane, focal length 1)
//                                      OUTPUT: X Y (ideal plane), "none", or "refused" for a lens without a rising
//                                      branch
#include <cstdio>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "core/camera/lens_map.h"

int main() {
    using namespace camrig;
    std::string line;
    while (std::getline(std::cin, line)) {
        std::istringstream words(line);
        std::string name;
        words >> name;
        const auto model = parse_name<camera::LensModel>(name);
        if (!model) {
            std::fprintf(stderr, "lens_probe: %s\n", model.error().message.c_str());
            return 1;
        }
        std::vector<double> k(static_cast<std::size_t>(coefficient_count(*model)));
        for (double& value : k) words >> value;
        glm::dvec2 point;
        words >> point.x >> point.y;
        if (!words) {
            std::fprintf(stderr, "lens_probe: not enough numbers: %s\n", line.c_str());
            return 1;
        }
        const auto lens = make_lens(*model, k);
        const auto map = lens ? camera::LensMap::create(*lens) : Result<camera::LensMap>(std::unexpected(lens.error()));
        if (!map) {
            std::puts("refused");
        } else if (const auto ideal = map->undistort(point)) {
            std::printf("%.17g %.17g\n", ideal->x, ideal->y);
        } else {
            std::puts("none");
        }
    }
    return 0;
}
