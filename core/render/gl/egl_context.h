#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "core/render/gl/gl_functions.h"

namespace camrig::render::gl {

struct EglLibrary;

/// An OpenGL 4.5 core context without any surface, current on the thread that created it until destroyed there.
class EglContext {
public:
    /// wanted "llvmpipe": Mesa's software device, also beside a vendor's driver. "N": EGL device N. "": the first
    /// hardware device that gives OpenGL 4.5 core; unavailable if there is none. Errors list the EGL devices there are.
    /// Other threads may run meanwhile, so nothing is told to Mesa by the environment.
    static Result<std::unique_ptr<EglContext>> create(const std::string& wanted);
    ~EglContext();
    EglContext(const EglContext&) = delete;
    EglContext& operator=(const EglContext&) = delete;

    const GlFunctions& gl() const { return gl_; }
    /// "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5 (Core Profile) Mesa 22.3.6"
    const std::string& description() const { return description_; }
    /// True for rasterisers that run on the CPU: pixels are already in host memory.
    bool is_software() const { return is_software_; }
    /// Vertex shaders know which draw of a multi-draw they are in (gl_DrawIDARB).
    bool has_draw_id() const { return has_draw_id_; }
    int max_texture_size() const { return max_texture_size_; }

private:
    explicit EglContext(const EglLibrary& egl) : egl_(&egl) {}
    Result<void> open(void* display, const std::string& what);
    void close() noexcept;

    const EglLibrary* egl_;
    void* display_ = nullptr;
    void* context_ = nullptr;
    GlFunctions gl_;
    std::string description_;
    bool is_software_ = false;
    bool has_draw_id_ = false;
    int max_texture_size_ = 0;
};

}  // namespace camrig::render::gl
