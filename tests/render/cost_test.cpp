#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/render/composed_renderer.h"
#include "tests/render/support/gallery.h"

namespace camrig::render {
namespace {

struct Priced {
    const char* name;
    world::Quality quality = world::Quality::simple;
    world::Antialias antialias = world::Antialias::none;
    camera::Lens lens = {};
    bool has_sensor = false;
};

/// A camera of the hall, no picture of which was drawn yet.
View view_of(const Film& hall, const Priced& priced) {
    View view = hall.view("lobby", {640, 480}, 1);
    auto spec = std::make_shared<world::CameraSpec>(*view.spec);
    spec->lens = priced.lens;
    spec->antialias = priced.antialias;
    if (priced.has_sensor) spec->sensor.emplace();
    view.spec = spec;
    view.quality = priced.quality;
    return view;
}

// Whoever places a camera before it has drawn anything compares prices, so it is their proportions that count: they are
// the same on machines of any speed.
TEST(ExpectedCost, IsInProportionToTheCpuTimeOfWholePictures) {
    const camera::Lens barrel =
        camera::make_lens(camera::LensModel::plumb_bob, std::vector{-0.25, 0.05, 0.001, -0.001, 0.0}).value();
    using enum world::Antialias;
    using enum world::Quality;
    const std::vector<Priced> all{{"simple"},
                                  {"simple, areas", simple, coverage},
                                  {"simple, lens", simple, none, barrel},
                                  {"simple, areas, lens", simple, coverage, barrel},
                                  {"beautiful", beautiful},
                                  {"beautiful, areas", beautiful, coverage},
                                  {"beautiful, areas, lens", beautiful, coverage, barrel},
                                  {"beautiful, sensor", beautiful, none, {}, true}};
    Film film("hall");
    const world::SnapshotRef moment = film.at(4 * ns_per_s);
    ComposedRenderer renderer({.pool = std::make_shared<frame::FramePool>()},
                              [] { return error(ErrorKind::unsupported, "nothing here is drawn elsewhere"); });
    std::vector<TimeNs> least_ns(all.size(), std::numeric_limits<TimeNs>::max());
    for (int round = 0; round < 4; ++round) {
        for (std::size_t i = 0; i < all.size(); ++i) {
            const View view = view_of(film, all[i]);
            const auto finished = renderer.draw(std::make_shared<world::Snapshot>(*moment), 0, {&view, 1});
            least_ns[i] = std::min(least_ns[i], finished.value().cost_ns.front());
        }
    }
    std::vector<double> ratios;
    double log_sum = 0.0;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const View view = view_of(film, all[i]);
        const auto pixels = static_cast<double>(view.spec->size.pixels());
        const auto took_ns = static_cast<double>(least_ns[i]);
        const auto expected_ns = static_cast<double>(renderer.expected_cost_ns(view));
        std::printf("%s: %.0f ns a pixel, expected %.0f\n", all[i].name, took_ns / pixels, expected_ns / pixels);
        log_sum += std::log(ratios.emplace_back(took_ns / expected_ns));
    }
    const double speed = std::exp(log_sum / static_cast<double>(all.size()));  // of the machine
    for (std::size_t i = 0; i < all.size(); ++i) {
        EXPECT_GT(ratios[i] / speed, 0.5) << all[i].name;
        EXPECT_LT(ratios[i] / speed, 2.0) << all[i].name;
    }
}

}  // namespace
}  // namespace camrig::render
