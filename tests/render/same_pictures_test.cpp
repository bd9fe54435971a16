#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <map>
#include <stdexcept>

#include <gtest/gtest.h>
#include <meshoptimizer.h>
#include <openssl/evp.h>

#include "core/frame/kind_format.h"
#include "core/render/composed_renderer.h"
#include "tests/render/support/gallery.h"

// Pictures of every shipped scene against the SHA-256 of their bytes in tests/render/expected, so that no change of the
// renderers changes a byte unnoticed. Each quality, kind, lens, way of antialiasing and readback is there, not each
// combination of them. After a change that is meant:
//
//   CAMRIG_WRITE_EXPECTED=1 build/ci/tests/render/test_same_pictures
namespace camrig::render {
namespace {

const std::vector<std::string> scenes{"hall", "street", "crowd", "clock", "calibration", "minimal"};
/// From where the world has moved a while. The first picture is drawn in full, with the second what stands still is
/// kept, then only what moves is drawn.
constexpr TimeNs first_ns = 4 * ns_per_s;
constexpr int instants = 4;
constexpr TimeNs between_ns = 120 * ns_per_ms;

constexpr std::array<std::string_view, frame::scene_kind_count> kind_names{"color", "depth", "instance", "semantic",
                                                                           "normal"};

const std::vector<frame::FrameKind> all_kinds{frame::FrameKind::color, frame::FrameKind::depth,
                                              frame::FrameKind::instance, frame::FrameKind::semantic,
                                              frame::FrameKind::normal};

/// One picture to draw of one of a scene's cameras.
struct Shot {
    std::size_t camera = 0;  ///< of the scene's; counted round
    ImageSize size{128, 96};
    world::Quality quality = world::Quality::simple;
    camera::Lens lens{};
    world::Antialias antialias = world::Antialias::none;
    std::vector<frame::FrameKind> kinds{frame::FrameKind::color};
    world::LensMethod method = world::LensMethod::automatic;
    bool has_extras = false;  ///< code strip and image controls
    bool shows_one = false;   ///< the first mover alone, or the first object
};

std::string name_of(const std::string& scene, const std::string& camera, const Shot& shot) {
    std::string name = scene + "/" + camera + "-" + std::string(to_string(shot.quality)) + "-" +
                       std::string(to_string(shot.lens.model));
    if (shot.method != world::LensMethod::automatic) name += "-" + std::string(to_string(shot.method));
    name += "-" + std::string(to_string(shot.antialias)) + "-" + shot.size.to_string();
    if (shot.has_extras) name += "-extras";
    if (shot.shows_one) name += "-alone";
    return name;
}

std::string sha256_of(const frame::Frame& frame) {
    std::array<unsigned char, 32> digest{};
    const auto bytes = frame.bytes();
    if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), nullptr, EVP_sha256(), nullptr) != 1)
        throw std::runtime_error("no SHA-256");
    std::string text;
    for (const unsigned char byte : digest) {
        constexpr std::string_view digits = "0123456789abcdef";
        text += digits[byte / 16];
        text += digits[byte % 16];
    }
    return text;
}

using Hashes = std::map<std::string, std::string>;  ///< by the picture's name

void draw_scene(Renderer& renderer, const std::string& scene, std::span<const Shot> shots, Hashes& hashes) {
    Film film(scene);
    const world::SnapshotRef first = film.at(first_ns);
    std::vector<View> views;
    std::vector<std::string> names;
    for (const Shot& shot : shots) {
        const std::string camera = film.camera(shot.camera);
        // Each scene has cameras of its own: a renderer keeps what it knows of one.
        static std::uint32_t number = 0;
        View view = film.view(camera, shot.size, ++number);
        auto spec = std::make_shared<world::CameraSpec>(*view.spec);
        spec->lens = shot.lens;
        spec->lens_sampling.method = shot.method;
        spec->antialias = shot.antialias;
        if (shot.has_extras) {
            spec->code_strip = true;
            spec->controls.gain_db = 3.0;
            spec->controls.saturation = 0.5;
        }
        view.camera_number = 7;
        view.spec = spec;
        view.quality = shot.quality;
        for (int k = 0; k < frame::scene_kind_count; ++k)
            view.kinds[k] = std::ranges::find(shot.kinds, static_cast<frame::FrameKind>(k)) != shot.kinds.end();
        for (const frame::PixelFormat format : frame::color_formats)
            if (renderer.makes(format, view)) view.color_formats.add(format);
        if (shot.shows_one)
            view.only_objects = {(first->movers.empty() ? first->statics->objects : first->movers).front().info->id};
        views.push_back(view);
        names.push_back(name_of(scene, camera, shot));
    }
    for (int n = 0; n < instants; ++n) {
        const TimeNs now_ns = first_ns + n * between_ns;
        for (View& view : views) view.sequence = n;
        const auto finished = renderer.draw(film.at(now_ns), 0, views).value();
        for (const auto& failure : finished.failures) ADD_FAILURE() << scene << ": " << failure.error.message;
        for (const frame::FrameRef& frame : finished.set.frames) {
            const frame::FrameInfo& info = frame->info();
            const auto view = std::ranges::find(views, info.camera_id, &View::camera) - views.begin();
            std::string name = names[static_cast<std::size_t>(view)] + "-" +
                               std::string(kind_names[static_cast<std::size_t>(info.kind)]);
            if (info.format != format_of(info.kind)) name += "-" + std::string(to_string(info.format));
            name += "@" + std::to_string(now_ns / ns_per_ms) + "ms";
            EXPECT_TRUE(hashes.emplace(name, sha256_of(*frame)).second) << name << " is there twice";
        }
    }
}

struct Expected {
    std::string drawn_by;
    Hashes hashes;
};

std::string file_of(const std::string& name) {
    return "tests/render/expected/" + name + ".sha256";
}

/// The first line says what drew them, each other one is "HASH  PICTURE".
Expected read_expected(const std::string& name) {
    std::ifstream file(file_of(name));
    Expected expected;
    std::getline(file, expected.drawn_by);
    for (std::string hash, picture; file >> hash >> picture;) expected.hashes[picture] = hash;
    return expected;
}

void compare(const std::string& name, const std::string& drawn_by, const Hashes& hashes) {
    if (std::getenv("CAMRIG_WRITE_EXPECTED") != nullptr) {
        std::ofstream file(file_of(name));
        file << drawn_by << "\n";
        for (const auto& [picture, hash] : hashes) file << hash << "  " << picture << "\n";
        ASSERT_TRUE(file.flush()) << "cannot write " << file_of(name);
        return;
    }
    const Expected expected = read_expected(name);
    ASSERT_FALSE(expected.hashes.empty()) << file_of(name) << " is missing";
    for (const auto& [picture, hash] : expected.hashes) {
        const auto found = hashes.find(picture);
        if (found == hashes.end()) {
            ADD_FAILURE() << picture << " is not drawn any more";
        } else {
            EXPECT_EQ(found->second, hash) << picture << " has other bytes";
        }
    }
    EXPECT_EQ(hashes.size(), expected.hashes.size())
        << "there are pictures that " << file_of(name) << " knows nothing of";
}

/// Mesa's bytes follow from its version, and where a CPU approximates (rcpps, rsqrtps) from who made that.
std::string kind_of(const Renderer& mesas) {
    return mesas.description() + (__builtin_cpu_is("intel") != 0 ? ", Intel" : ", not Intel");
}

const camera::Lens plumb_bob{camera::LensModel::plumb_bob, {-0.28, 0.07, 0.0007, -0.0004, -0.01}};
const camera::Lens equidistant{camera::LensModel::equidistant, {-0.01, 0.004, -0.002, 0.0003}};
const camera::Lens rational{camera::LensModel::rational_polynomial,
                            {0.3, -0.1, 0.0005, 0.0003, 0.01, 0.6, -0.05, 0.02}};

ComposedRenderer own_rasteriser(double max_detail_error_px) {
    return ComposedRenderer(
        {.pool = std::make_shared<frame::FramePool>(),
         .static_layer_bytes = RendererOptions{}.static_layer_bytes,
         .max_detail_error_px = max_detail_error_px,
         .threads = 2},
        [] { return error(ErrorKind::unsupported, "this picture is not one of our rasteriser's"); });
}

TEST(SamePictures, OfOurRasteriser) {
    ComposedRenderer renderer = own_rasteriser(0);
    // Rows of 117 pixels are no whole groups of lanes.
    const std::vector<Shot> shots{
        {.camera = 0},
        {.camera = 1, .size = {117, 88}, .quality = world::Quality::fast},
        {.camera = 2, .size = {320, 240}},
        {.camera = 2, .size = {64, 48}, .has_extras = true},
        {.camera = 1, .size = {90, 68}, .kinds = all_kinds},
        {.camera = 0, .lens = plumb_bob, .kinds = all_kinds},
        {.camera = 1, .size = {117, 88}, .quality = world::Quality::fast, .lens = rational},
        {.camera = 2, .size = {160, 120}, .lens = equidistant},
        {.camera = 0, .quality = world::Quality::beautiful, .kinds = all_kinds},
        {.camera = 1, .size = {117, 88}, .quality = world::Quality::beautiful, .lens = plumb_bob},
        {.camera = 1, .size = {117, 88}, .antialias = world::Antialias::coverage, .kinds = all_kinds},
        {.camera = 2, .size = {160, 120}, .quality = world::Quality::fast, .antialias = world::Antialias::coverage},
        {.camera = 0, .quality = world::Quality::beautiful, .antialias = world::Antialias::coverage}};
    Hashes hashes;
    for (const std::string& scene : scenes) draw_scene(renderer, scene, shots, hashes);
    // The same on every machine, whatever its vectors and compiler.
    compare("own_rasteriser", "camrig's rasteriser", hashes);
}

// Their coarse meshes are made by meshoptimizer, of which each version makes others.
TEST(SamePictures, OfPeopleFarAway) {
    const std::string made_by = "meshoptimizer " + std::to_string(MESHOPTIMIZER_VERSION);
    if (std::getenv("CAMRIG_WRITE_EXPECTED") == nullptr) {
        const std::string known = read_expected("people_far_away").drawn_by;
        if (known != made_by) GTEST_SKIP() << "the bytes are known of '" << known << "', here is '" << made_by << "'";
    }
    ComposedRenderer renderer = own_rasteriser(RendererOptions{}.max_detail_error_px);
    const std::vector<Shot> shots{{.camera = 0, .kinds = all_kinds},
                                  {.camera = 1, .size = {117, 88}, .quality = world::Quality::fast},
                                  {.camera = 2, .size = {64, 48}, .quality = world::Quality::beautiful}};
    Hashes hashes;
    for (const char* scene : {"hall", "street", "crowd"}) draw_scene(renderer, scene, shots, hashes);
    compare("people_far_away", made_by, hashes);
}

TEST(SamePictures, OfMesasRasteriser) {
    auto renderer = create_renderer({.device = "llvmpipe", .pool = std::make_shared<frame::FramePool>()}).value();
    if (std::getenv("CAMRIG_WRITE_EXPECTED") == nullptr) {
        const std::string known = read_expected("llvmpipe").drawn_by;
        if (known != kind_of(*renderer))
            GTEST_SKIP() << "the bytes are known of '" << known << "', here is '" << kind_of(*renderer) << "'";
    }
    const std::vector<frame::FrameKind> truth{frame::FrameKind::depth, frame::FrameKind::instance,
                                              frame::FrameKind::semantic, frame::FrameKind::normal};
    const std::vector<frame::FrameKind> color_depth{frame::FrameKind::color, frame::FrameKind::depth};
    const std::vector<Shot> everywhere{
        {.camera = 0, .kinds = color_depth},
        {.camera = 1, .size = {117, 88}, .quality = world::Quality::fast},
        {.camera = 2, .quality = world::Quality::beautiful, .antialias = world::Antialias::msaa4, .kinds = all_kinds},
        {.camera = 0, .lens = plumb_bob, .kinds = all_kinds},
        {.camera = 1, .quality = world::Quality::beautiful, .lens = equidistant, .kinds = color_depth}};
    const std::vector<Shot> in_one_scene{
        {.camera = 0, .quality = world::Quality::beautiful, .kinds = truth},
        {.camera = 1, .lens = rational, .antialias = world::Antialias::ssaa2, .method = world::LensMethod::cube},
        {.camera = 2, .antialias = world::Antialias::ssaa2, .has_extras = true},
        {.camera = 0, .lens = equidistant, .antialias = world::Antialias::msaa4},
        {.camera = 1, .kinds = {frame::FrameKind::instance}, .shows_one = true}};
    Hashes hashes;
    for (const std::string& scene : scenes) draw_scene(*renderer, scene, everywhere, hashes);
    for (const char* scene : {"street", "minimal"}) draw_scene(*renderer, scene, in_one_scene, hashes);
    const std::string drawn_by = kind_of(*renderer);
    renderer.reset();
    // As on a GPU: colours converted on the device, pixels through a buffer, movers of one instant after the other's.
    auto as_gpu =
        create_renderer(
            {.device = "llvmpipe", .pool = std::make_shared<frame::FramePool>(), .conversion = Conversion::device})
            .value();
    draw_scene(*as_gpu, "hall", std::vector<Shot>{{.camera = 1, .size = {160, 96}, .kinds = color_depth}}, hashes);
    compare("llvmpipe", drawn_by, hashes);
}

}  // namespace
}  // namespace camrig::render
