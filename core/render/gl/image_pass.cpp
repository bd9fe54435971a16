#include "core/render/gl/image_pass.h"

#include <utility>

#include <spdlog/spdlog.h>

#include "core/render/gl/shader_program.h"
#include "core/render/gl/shader_sources.h"

namespace camrig::render::gl {
namespace {

std::string define(const char* name, int value) {
    return "#define " + std::string(name) + " " + std::to_string(value) + "\n";
}

std::string define_nowhere() {
    return define("NOWHERE", LensPlan::nowhere.x);
}

}  // namespace

ImagePass::ImagePass(const GlFunctions& gl, bool has_float_units)
    : gl_(gl),
      no_vertices_(make_vertex_array(gl)),
      has_float_units_(has_float_units),
      nearest_(make_sampler(gl)),
      linear_(make_sampler(gl)) {
    // Integer textures are complete only with nearest.
    for (const auto& [sampler, filter] : {std::pair(nearest_.name(), GL_NEAREST), {linear_.name(), GL_LINEAR}}) {
        gl_.SamplerParameteri(sampler, GL_TEXTURE_MIN_FILTER, filter);
        gl_.SamplerParameteri(sampler, GL_TEXTURE_MAG_FILTER, filter);
    }
}

GLuint ImagePass::program(const std::string& defines, const std::string& fragment) {
    GlProgram& program = programs_[defines];
    if (!program) {
        auto built = build_program(gl_, "image", defines, shader_source::image_vert, shader_source::srgb + fragment);
        if (!built) spdlog::critical("{}", built.error().message);
        CHECK(built.has_value());
        program = std::move(*built);
    }
    return program.name();
}

void ImagePass::draw(GLuint program, GLuint framebuffer, ImageSize size, std::initializer_list<Input> inputs) {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl_.Viewport(0, 0, size.width, size.height);
    gl_.Disable(GL_DEPTH_TEST);
    gl_.Disable(GL_CULL_FACE);
    gl_.UseProgram(program);
    for (const Input& input : inputs) {
        gl_.BindTextureUnit(input.unit, input.texture);
        gl_.BindSampler(input.unit, input.is_filtered ? linear_.name() : nearest_.name());
    }
    gl_.BindVertexArray(no_vertices_.name());
    gl_.DrawArrays(GL_TRIANGLES, 0, 3);
}

void ImagePass::resolve(const ColorTarget& source, int supersampling, const ColorTarget& to) {
    const std::string defines = source.samples > 1 ? define("MULTISAMPLES", source.samples)
                                                   : define("RESOLVE", 1) + define("SUPERSAMPLING", supersampling);
    draw(program(defines, shader_source::resolve_frag), to.framebuffer.name(), to.size, {{0, source.color.name()}});
}

void ImagePass::warp_color(const LensOnDevice& lens, const ColorTarget& source, int supersampling, bool is_bicubic,
                           const ColorTarget& to) {
    std::string defines = define_nowhere() + define("SUPERSAMPLING", supersampling);
    if (is_bicubic && supersampling == 1) defines += define("BICUBIC", 1);
    if (has_float_units_) defines += define("FLOAT_UNITS", 1);
    const Input color{0, source.color.name(), has_float_units_};
    const GLuint shader = program(defines, shader_source::warp_color_frag);
    if (supersampling == 1) {
        draw(shader, to.framebuffer.name(), to.size, {color, {1, lens.map.name()}});
    } else {
        draw(shader, to.framebuffer.name(), to.size, {color, {1, lens.map.name()}, {2, lens.footprint.name()}});
    }
}

void ImagePass::warp_truth(const LensOnDevice& lens, const TruthTarget& source, const TruthTarget& to) {
    draw(program(define_nowhere(), shader_source::warp_truth_frag), to.framebuffer.name(), to.size,
         {{0, source.depth.name()}, {1, lens.map.name()}, {2, source.instance.name()}, {3, source.normal.name()}});
}

void ImagePass::warp_depth(const LensOnDevice& lens, const ColorTarget& source, const TruthTarget& to) {
    draw(program(define_nowhere() + define("DEPTH_ONLY", 1), shader_source::warp_truth_frag), to.framebuffer.name(),
         to.size, {{0, source.depth.name()}, {1, lens.map.name()}});
}

}  // namespace camrig::render::gl
