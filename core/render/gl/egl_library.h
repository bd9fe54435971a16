#pragma once

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include "core/base/result.h"

namespace camrig::render::gl {

#define CAMRIG_EGL_FUNCTIONS(use)                                                                             \
    use(eglGetProcAddress, PFNEGLGETPROCADDRESSPROC) use(eglGetPlatformDisplay, PFNEGLGETPLATFORMDISPLAYPROC) \
        use(eglInitialize, PFNEGLINITIALIZEPROC) use(eglBindAPI, PFNEGLBINDAPIPROC)                           \
            use(eglCreateContext, PFNEGLCREATECONTEXTPROC) use(eglDestroyContext, PFNEGLDESTROYCONTEXTPROC)   \
                use(eglMakeCurrent, PFNEGLMAKECURRENTPROC)

/// libEGL, opened when something of it is first needed: a rig that draws all its pictures by itself never loads a
/// driver. It stays open: drivers do not survive being unloaded.
struct EglLibrary {
#define CAMRIG_EGL_MEMBER(name, type) type name = nullptr;
    CAMRIG_EGL_FUNCTIONS(CAMRIG_EGL_MEMBER)
#undef CAMRIG_EGL_MEMBER

    /// unsupported: it is not installed, or too old. Any thread.
    static Result<const EglLibrary*> open();
};

/// Whether the kernel shows a device that a driver of a GPU would use: where there is none, none needs to be looked
/// for.
bool has_gpu_node();

}  // namespace camrig::render::gl
