#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/frame/frame_pool.h"
#include "core/render/renderer.h"
#include "core/render/shared_caches.h"

namespace camrig::render {

/// Where colour pictures become what readers take: YUV, BGR.
enum class Conversion : std::uint8_t {
    automatic,  ///< on the device if it is hardware
    host,       ///< on the threads that encode
    device,     ///< by a shader, before the pixels are read back
};

struct RendererOptions {
    /// "null": deterministic pattern, no GL. "cpu": camrig's own rasteriser, and Mesa llvmpipe for what it does not
    /// draw. "llvmpipe": by that. "N": by EGL device N. "": by a hardware device if there is one, else "cpu".
    /// What OpenGL does not draw, camrig's rasteriser does on all of them (ComposedRenderer).
    std::string device;
    std::shared_ptr<frame::FramePool> pool;
    SharedCaches caches{};  ///< shared with other renderers; empty: its own
    /// Memory for pictures of what does not move (static_layers.h); 0: everything is drawn each time.
    std::int64_t static_layer_bytes = std::int64_t{256} << 20;
    /// A coarser level of a skinned mesh is drawn where its error is below this; 0: never.
    double max_detail_error_px = 0.25;
    Conversion conversion = Conversion::automatic;
    /// Surfaces that differ only in mesh and place are drawn by one call of OpenGL, where the driver can; the same
    /// bytes.
    bool batch_draws = true;
    /// Pixels come to host memory as from a GPU on a CPU rasteriser too: the same bytes, slower; for tests.
    bool buffered_readback = false;
    /// Threads of our rasteriser; 0 = as many as cores. llvmpipe reads LP_NUM_THREADS.
    int raster_threads = 0;
};

/// Errors say which devices there are.
Result<std::unique_ptr<Renderer>> create_renderer(const RendererOptions& options);

}  // namespace camrig::render
