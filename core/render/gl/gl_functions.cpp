#include "core/render/gl/gl_functions.h"

#include <string>

namespace camrig::render::gl {

Result<void> GlFunctions::load(void (*(*address_of)(const char* name))()) {
#define CAMRIG_GL_LOAD(name, NAME)                                                                               \
    name = reinterpret_cast<PFNGL##NAME##PROC>(address_of("gl" #name));                                          \
    if (name == nullptr) {                                                                                       \
        return error(ErrorKind::unsupported, "the OpenGL driver has no gl" #name "; OpenGL 4.5 core is needed"); \
    }
    CAMRIG_GL_FUNCTIONS(CAMRIG_GL_LOAD)
#undef CAMRIG_GL_LOAD
    return {};
}

bool is_out_of_memory(const GlFunctions& gl) {
    bool is_out = false;
    for (GLenum code = gl.GetError(); code != GL_NO_ERROR; code = gl.GetError()) is_out |= code == GL_OUT_OF_MEMORY;
    return is_out;
}

}  // namespace camrig::render::gl
