// Draws one picture of a scene, or measures how long that takes: for looking at scenes and at the renderer.
//
//   render_scene SCENE VIEW OUT.png [--size WxH] [--quality fast|simple|beautiful] [--time SECONDS]
//                [--kind color|depth|instance] [--device cpu] [--bench FRAMES] [--cameras N] [--threads N]
//                [--lens MODEL:K1,K2,...] [--intrinsics FX,FY,CX,CY] [--method auto|warp|cube]
//                [--filter auto|bilinear|bicubic] [--antialias none|coverage|msaa4|ssaa2|ssaa3|ssaa4]
//                [--static-layer on|off] [--moving on|off]
//                [--detail-error PIXELS]
//
// VIEW is the name of a camera or place of the scene, or X,Y,Z,TX,TY,TZ (eye and target); several names, joined by +,
// give the cameras of --bench their places in turn. --moving turns them a little before every picture.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <sstream>

#include "core/camera/lens_map.h"
#include "core/codec/encoder.h"
#include "core/render/renderer_factory.h"
#include "core/world/world.h"

namespace camrig::render {
namespace {

struct Arguments {
    std::string scene, view, out;
    ImageSize size{640, 480};
    world::Quality quality = world::Quality::simple;
    double time_s = 0.0;
    frame::FrameKind kind = frame::FrameKind::color;
    std::string device = "cpu";
    int bench_frames = 0;
    int cameras = 1;
    int threads = 0;
    bool has_static_layer = true;
    bool is_moving = false;
    double max_detail_error_px = RendererOptions{}.max_detail_error_px;
    camera::Lens lens{};
    world::LensSampling sampling{};
    world::Antialias antialias = world::Antialias::none;
    std::optional<camera::Intrinsics> intrinsics = std::nullopt;
};

[[noreturn]] void fail(const std::string& message) {
    std::fprintf(stderr, "render_scene: %s\n", message.c_str());
    std::exit(1);
}

camera::Lens parse_lens(const std::string& text) {
    const auto colon = text.find(':');
    const auto model = parse_name<camera::LensModel>(text.substr(0, colon));
    if (!model) fail(model.error().message);
    std::vector<double> numbers;
    std::istringstream list(colon == std::string::npos ? "" : text.substr(colon + 1));
    for (std::string number; std::getline(list, number, ',');) numbers.push_back(std::stod(number));
    const auto lens = make_lens(*model, numbers);
    if (!lens) fail(lens.error().message);
    return *lens;
}

template <typename T>
T must(Result<T> result) {
    if (!result) fail(result.error().message);
    return *result;
}

Arguments parse(int argc, char** argv) {
    if (argc < 4) fail("needs SCENE VIEW OUT.png; see the top of render_scene.cpp");
    Arguments a{.scene = argv[1], .view = argv[2], .out = argv[3]};
    for (int i = 4; i + 1 < argc; i += 2) {
        const std::string option = argv[i];
        const std::string value = argv[i + 1];
        if (option == "--size") std::sscanf(argv[i + 1], "%dx%d", &a.size.width, &a.size.height);
        if (option == "--quality") a.quality = parse_name<world::Quality>(value).value_or(world::Quality::simple);
        if (option == "--time") a.time_s = std::stod(value);
        if (option == "--kind" && value == "depth") a.kind = frame::FrameKind::depth;
        if (option == "--kind" && value == "instance") a.kind = frame::FrameKind::instance;
        if (option == "--device") a.device = value;
        if (option == "--bench") a.bench_frames = std::stoi(value);
        if (option == "--cameras") a.cameras = std::stoi(value);
        if (option == "--threads") a.threads = std::stoi(value);
        if (option == "--detail-error") a.max_detail_error_px = std::stod(value);
        if (option == "--moving") a.is_moving = value == "on";
        if (option == "--static-layer") a.has_static_layer = value == "on";
        if (option == "--lens") a.lens = parse_lens(value);
        if (option == "--method") a.sampling.method = must(parse_name<world::LensMethod>(value));
        if (option == "--filter") a.sampling.filter = must(parse_name<world::LensFilter>(value));
        if (option == "--antialias") a.antialias = must(parse_name<world::Antialias>(value));
        if (option == "--intrinsics") {
            camera::Intrinsics k;
            std::sscanf(argv[i + 1], "%lf,%lf,%lf,%lf", &k.fx, &k.fy, &k.cx, &k.cy);
            a.intrinsics = k;
        }
    }
    return a;
}

View view_of(const world::Scene& scene, const Arguments& a, const std::string& name) {
    camera::Pose pose;
    double vfov = 1.0471975511965976;
    double n[6];
    const auto place = scene.places.find(name);
    if (place != scene.places.end()) {
        pose = place->second.pose;
        vfov = place->second.vfov_rad;
    } else if (std::sscanf(name.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf", n, n + 1, n + 2, n + 3, n + 4, n + 5) == 6) {
        auto looking = camera::pose_look_at({n[0], n[1], n[2]}, {n[3], n[4], n[5]});
        if (!looking) fail(looking.error().message);
        pose = *looking;
    } else {
        bool found = false;
        for (const world::CameraSpec& camera : scene.cameras) {
            if (camera.name != name) continue;
            pose = camera.pose;
            vfov = vfov_rad(camera.size, camera.intrinsics);
            found = true;
        }
        if (!found) {
            std::string names;
            for (const auto& [known, unused] : scene.places) names += " " + known;
            for (const world::CameraSpec& camera : scene.cameras) names += " " + camera.name;
            fail("no view '" + name + "' in this scene; it has" + names);
        }
    }
    auto spec = std::make_shared<world::CameraSpec>();
    spec->name = "view";
    spec->size = a.size;
    spec->intrinsics = a.intrinsics.value_or(*camera::intrinsics_from_vfov(a.size, vfov));
    spec->lens = a.lens;
    spec->lens_sampling = a.sampling;
    spec->antialias = a.antialias;
    View view;
    view.camera = CameraId{1};
    view.name = std::make_shared<const std::string>("view");
    view.spec = std::move(spec);
    view.pose = pose;
    view.quality = a.quality;
    std::fill(std::begin(view.kinds), std::end(view.kinds), false);
    view.kinds[static_cast<int>(a.kind)] = true;
    return view;
}

double ms_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/// Of all threads of this process: what the machine's other work does not change.
double cpu_ms() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

/// Every camera turned about the world's up axis, by another angle in each picture.
void turn(std::vector<View>& views, int picture) {
    const glm::dquat by = glm::angleAxis(picture % 2 == 0 ? 0.001 : -0.001, glm::dvec3(0.0, 0.0, 1.0));
    for (View& view : views) view.pose.orientation = glm::normalize(by * view.pose.orientation);
}

void bench(world::World& world, Renderer& renderer, std::vector<View> views, const Arguments& a) {
    double world_ms = 0, draw_ms = 0, cpu_before = 0;
    constexpr int warm_up = 5;
    for (int i = -warm_up; i < a.bench_frames; ++i) {
        if (i == 0) {
            world_ms = draw_ms = 0;
            cpu_before = cpu_ms();
        }
        const TimeNs now = static_cast<TimeNs>(a.time_s * 1e9) + (i + warm_up + 1) * 40 * ns_per_ms;
        const auto start = std::chrono::steady_clock::now();
        world.advance_to(now);
        const world::SnapshotRef snapshot = world.snapshot(now);
        world_ms += ms_since(start);
        if (a.is_moving) turn(views, i + warm_up);
        const auto draw = std::chrono::steady_clock::now();
        if (auto done = renderer.draw(snapshot, 0, views); !done) fail(done.error().message);
        draw_ms += ms_since(draw);
    }
    const double cpu = cpu_ms() - cpu_before;
    const double pictures = static_cast<double>(a.bench_frames) * static_cast<double>(views.size());
    std::printf("%s %s %zu cameras: %.2f ms a picture (%.1f/s), CPU %.2f ms; per instant: world %.2f, draw %.2f ms\n",
                a.size.to_string().c_str(), std::string(to_string(a.quality)).c_str(), views.size(), draw_ms / pictures,
                1000.0 * pictures / (world_ms + draw_ms), cpu / pictures, world_ms / a.bench_frames,
                draw_ms / a.bench_frames);
}

int run(const Arguments& a) {
    auto start = std::chrono::steady_clock::now();
    auto scene = world::load_scene(a.scene);
    if (!scene) fail(scene.error().message);
    auto world = world::World::create(*scene, 1);
    if (!world) fail(world.error().message);
    std::printf("loaded in %.0f ms\n", ms_since(start));
    RendererOptions options{
        .device = a.device, .pool = std::make_shared<frame::FramePool>(), .raster_threads = a.threads};
    options.max_detail_error_px = a.max_detail_error_px;
    if (!a.has_static_layer) options.static_layer_bytes = 0;
    auto renderer = create_renderer(options);
    if (!renderer) fail(renderer.error().message);
    std::printf("%s\n", (*renderer)->description().c_str());

    std::vector<std::string> names;
    std::istringstream joined(a.view);
    for (std::string name; std::getline(joined, name, '+');) names.push_back(name);
    if (names.empty()) fail("VIEW is empty");
    const View view = view_of(**scene, a, names.front());
    const auto now = static_cast<TimeNs>(a.time_s * 1e9);
    (*world)->advance_to(now);
    start = std::chrono::steady_clock::now();
    auto finished = (*renderer)->draw((*world)->snapshot(now), 0, {&view, 1});
    if (!finished) fail(finished.error().message);
    for (const auto& failure : finished->failures) fail(failure.error.message);
    std::printf("first picture in %.0f ms\n", ms_since(start));

    auto png = codec::create_png_encoder();
    if (!png) fail(png.error().message);
    auto bytes = (*png)->encode(*finished->set.frames.at(0));
    if (!bytes) fail(bytes.error().message);
    std::ofstream(a.out, std::ios::binary)
        .write(reinterpret_cast<const char*>((*bytes)->data()), static_cast<std::streamsize>((*bytes)->size()));

    if (a.bench_frames > 0) {
        std::vector<View> views;
        for (std::size_t i = 0; i < static_cast<std::size_t>(a.cameras); ++i) {
            views.push_back(view_of(**scene, a, names[i % names.size()]));
            views.back().camera = CameraId{static_cast<std::uint32_t>(i + 1)};
        }
        bench(**world, **renderer, views, a);
    }
    return 0;
}

}  // namespace
}  // namespace camrig::render

int main(int argc, char** argv) {
    const auto arguments = camrig::render::parse(argc, argv);
    // For llvmpipe, while there is no other thread.
    if (arguments.threads > 0) ::setenv("LP_NUM_THREADS", std::to_string(arguments.threads).c_str(), 1);
    return camrig::render::run(arguments);
}
