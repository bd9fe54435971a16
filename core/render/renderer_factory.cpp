#include "core/render/renderer_factory.h"

#include <algorithm>
#include <thread>

#include "core/render/null_renderer.h"
#include "core/render/software/cpu_renderer.h"
#ifdef CAMRIG_HAS_GL
#include "core/render/gl/gl_renderer.h"
#endif

namespace camrig::render {

namespace {

Result<std::unique_ptr<Renderer>> create_gl_renderer(const RendererOptions& options) {
#ifdef CAMRIG_HAS_GL
    return gl::GlRenderer::create(options);
#else
    return error(ErrorKind::unsupported, "this build has no GL renderer; the device can only be 'cpu' or 'null'");
#endif
}

}  // namespace

Result<std::unique_ptr<Renderer>> create_renderer(const RendererOptions& options) {
    CHECK(options.pool != nullptr);
    const bool may_be_gl = options.device != "null" && options.device != "cpu";
    if (may_be_gl) {
        auto on_device = create_gl_renderer(options);
        if (on_device || !options.device.empty()) return on_device;
    }
    if (options.conversion == Conversion::device) {
        return error(ErrorKind::invalid_argument,
                     "colours cannot be converted on the device: " +
                         (may_be_gl ? "there is no GPU here" : "'" + options.device + "' draws in host memory") +
                         "; convert on the host, or draw on a GPU or llvmpipe");
    }
    if (options.device == "null") return std::make_unique<NullRenderer>(options.pool);
    RendererOptions for_the_rest = options;
    for_the_rest.device = "llvmpipe";
    if (for_the_rest.caches.software == nullptr) for_the_rest.caches = make_shared_caches();
    const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    return std::make_unique<software::CpuRenderer>(
        software::SoftwareDrawer::Options{.pool = options.pool,
                                          .caches = for_the_rest.caches,
                                          .static_layer_bytes = options.static_layer_bytes,
                                          .max_detail_error_px = options.max_detail_error_px,
                                          .threads = options.raster_threads > 0 ? options.raster_threads : cores},
        [for_the_rest] { return create_gl_renderer(for_the_rest); });
}

}  // namespace camrig::render
