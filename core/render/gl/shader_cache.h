#pragma once

#include <compare>
#include <map>

#include "core/render/gl/gl_objects.h"
#include "core/render/gl/shader_key.h"

namespace camrig::render::gl {

/// Which shader writes depth and what follows from place alone: `masked`, with alpha test on the base colour, of which
/// the others say what it is made of.
struct DepthKey {
    bool masked = false;
    bool uv1 = false;
    bool has_color = false;
    bool textured = false;
    bool batched = false;  ///< several draws at once (DrawPass)
    friend auto operator<=>(const DepthKey&, const DepthKey&) = default;
};

/// Programs by key, each compiled once. Few keys are ever used by one scene; none is evicted.
class ShaderCache {
public:
    explicit ShaderCache(const GlFunctions& gl) : gl_(gl) {}

    /// The program of a key. A shader that does not compile is our bug (every combination of features is tested).
    GLuint program(const ShaderKey& key);
    /// Writes ids and normals for the ground truth.
    GLuint truth_program(DepthKey key);
    /// Writes distances from a light.
    GLuint shadow_program(DepthKey key);
    std::size_t size() const { return programs_.size(); }

private:
    using DepthPrograms = std::map<DepthKey, GlProgram>;
    GLuint depth_program(const char* name, DepthPrograms& programs, const char* vertex, const char* fragment,
                         DepthKey key);

    const GlFunctions& gl_;
    std::map<ShaderKey, GlProgram> programs_;
    DepthPrograms truth_programs_, shadow_programs_;
};

}  // namespace camrig::render::gl
