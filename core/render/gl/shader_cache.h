#pragma once

#include <map>

#include "core/render/gl/gl_objects.h"
#include "core/render/gl/shader_key.h"

namespace camrig {

/// Programs by key, each compiled once. Few keys are ever used by one scene; none is evicted.
class ShaderCache {
public:
    explicit ShaderCache(const GlFunctions& gl) : gl_(gl) {}

    /// The program of a key. A shader that does not compile is our bug (every combination of features is tested).
    GLuint program(const ShaderKey& key);
    /// Writes ids and normals for the ground truth; `masked`: with alpha test on the base colour.
    GLuint truth_program(bool masked, bool uv1, bool has_color, bool textured);
    /// Writes distances from a light; `masked` as above.
    GLuint shadow_program(bool masked, bool uv1, bool has_color, bool textured);
    std::size_t size() const { return programs_.size(); }

private:
    GLuint depth_program(const char* name, std::map<int, GlProgram>& programs, const char* vertex, const char* fragment,
                         bool masked, bool uv1, bool has_color, bool textured);

    const GlFunctions& gl_;
    std::map<ShaderKey, GlProgram> programs_;
    std::map<int, GlProgram> truth_programs_, shadow_programs_;
};

}  // namespace camrig
