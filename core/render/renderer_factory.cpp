#include "core/render/renderer_factory.h"

#include <algorithm>
#include <thread>

#include "core/render/composed_renderer.h"
#include "core/render/null_renderer.h"
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
    const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    RendererOptions shared = options;
    if (shared.caches.software == nullptr) shared.caches = make_shared_caches();
    const software::SoftwareDrawer::Options ours{
        .pool = options.pool,
        .caches = shared.caches,
        .static_layer_bytes = options.static_layer_bytes,
        .max_detail_error_px = options.max_detail_error_px,
        .threads = options.raster_threads > 0 ? options.raster_threads : cores};
    const bool may_be_gl = options.device != "null" && options.device != "cpu";
    if (may_be_gl) {
        auto on_device = create_gl_renderer(shared);
        if (on_device) return std::make_unique<ComposedRenderer>(ours, std::move(*on_device));
        if (!options.device.empty()) return on_device;
    }
    if (options.conversion == Conversion::device) {
        return error(ErrorKind::invalid_argument,
                     "colours cannot be converted on the device: " +
                         (may_be_gl ? "there is no GPU here" : "'" + options.device + "' draws in host memory") +
                         "; convert on the host, or draw on a GPU or llvmpipe");
    }
    if (options.device == "null") return std::make_unique<NullRenderer>(options.pool);
    shared.device = "llvmpipe";
    return std::make_unique<ComposedRenderer>(ours, [shared] { return create_gl_renderer(shared); });
}

}  // namespace camrig::render
