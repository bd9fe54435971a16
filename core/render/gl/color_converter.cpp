#include "core/render/gl/color_converter.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/frame/yuv_matrix.h"
#include "core/render/gl/shader_program.h"
#include "core/render/gl/shader_sources.h"

namespace camrig::render::gl {
namespace {

constexpr int group_words = 64;
/// Groups in one row of the dispatch; every device takes 65535 in each direction.
constexpr GLuint groups_per_row = 1024;

std::string macro(const std::string& name, const std::string& value = {}) {
    return "#define " + name + " " + value + "\n";
}

std::string factors_macro(const std::string& name, int r, int g, int b) {
    return macro(name, "ivec3(" + std::to_string(r) + ", " + std::to_string(g) + ", " + std::to_string(b) + ")");
}

std::string matrix_macros(const frame::YuvMatrix& m) {
    return factors_macro("Y_FACTORS", m.yr, m.yg, m.yb) + factors_macro("U_FACTORS", m.ur, m.ug, m.ub) +
           factors_macro("V_FACTORS", m.vr, m.vg, m.vb) + macro("Y_OFFSET", std::to_string(m.y_offset)) +
           macro("Y_BITS", std::to_string(m.fraction_bits)) + macro("SUM_OFFSET", std::to_string(m.sum_offset)) +
           macro("SUM_BITS", std::to_string(m.sum_bits));
}

std::string defines_of(frame::PixelFormat format) {
    const bool is_full = format == frame::PixelFormat::jpeg_i420 || format == frame::PixelFormat::gray8;
    std::string text = macro("GROUP_WORDS", std::to_string(group_words)) +
                       matrix_macros(is_full ? frame::full_yuv : frame::limited_yuv);
    if (format == frame::PixelFormat::rgb24) text += macro("PACKED_24") + macro("CHANNEL(i)", "(i)");
    if (format == frame::PixelFormat::bgr24) text += macro("PACKED_24") + macro("CHANNEL(i)", "(2 - (i))");
    if (format == frame::PixelFormat::yuyv) text += macro("YUYV");
    if (format == frame::PixelFormat::nv12) text += macro("NV12");
    return text;
}

}  // namespace

ColorConverter::ColorConverter(const GlFunctions& gl) : gl_(gl), nearest_(make_sampler(gl)) {
    // Integer textures are complete only with nearest.
    gl_.SamplerParameteri(nearest_.name(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl_.SamplerParameteri(nearest_.name(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    GLint64 max_bytes = 0;
    gl_.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &max_bytes);
    max_bytes_ = static_cast<std::size_t>(max_bytes);
}

Result<ColorConverter> ColorConverter::create(const GlFunctions& gl) {
    ColorConverter converter(gl);
    for (const frame::PixelFormat format : frame::color_formats) {
        if (format == frame::PixelFormat::rgba8) continue;
        auto program = build_compute_program(gl, "convert", defines_of(format), shader_source::convert_comp);
        if (!program) return std::unexpected(program.error());
        converter.programs_.emplace(format, std::move(*program));
    }
    return converter;
}

bool ColorConverter::can_make(frame::PixelFormat format, ImageSize size) const {
    return programs_.contains(format) && bytes_of(format, size) + 3 <= max_bytes_;
}

void ColorConverter::convert(GLuint codes, ImageSize size, frame::PixelFormat format, GLuint buffer, GLintptr offset) {
    CHECK(can_make(format, size));
    const auto words = static_cast<GLuint>((bytes_of(format, size) + 3) / 4);
    const GLuint groups = (words + group_words - 1) / group_words;
    gl_.UseProgram(programs_.at(format).name());
    gl_.BindTextureUnit(0, codes);
    gl_.BindSampler(0, nearest_.name());
    gl_.BindBufferRange(GL_SHADER_STORAGE_BUFFER, 0, buffer, offset, GLsizeiptr{4} * words);
    gl_.DispatchCompute(std::min(groups, groups_per_row), (groups + groups_per_row - 1) / groups_per_row, 1);
}

}  // namespace camrig::render::gl
