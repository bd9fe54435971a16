#include "core/render/renderer_factory.h"

#include "core/render/null_renderer.h"
#ifdef CAMRIG_HAS_GL
#include "core/render/gl/gl_renderer.h"
#endif

namespace camrig {

Result<std::unique_ptr<Renderer>> create_renderer(const RendererOptions& options) {
    CHECK(options.pool != nullptr);
    if (options.device == "null") return std::make_unique<NullRenderer>(options.pool);
#ifdef CAMRIG_HAS_GL
    return GlRenderer::create(options);
#else
    return error(ErrorKind::unsupported, "this build has no GL renderer; the device can only be 'null'");
#endif
}

}  // namespace camrig
