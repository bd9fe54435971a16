#include "core/world/png_reader.h"

#include <csetjmp>
#include <cstring>
#include <string>

#include <png.h>

namespace camrig::world {

struct PngReader::State {
    std::span<const std::byte> file;
    std::size_t offset = 0;
    char message[160] = "";
    std::jmp_buf jump{};
    png_structp png = nullptr;
    png_infop info = nullptr;

    State() = default;
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State() { png_destroy_read_struct(&png, &info, nullptr); }

    static void fail(png_structp png, png_const_charp message) {
        auto* const self = static_cast<State*>(png_get_error_ptr(png));
        std::strncpy(self->message, message, sizeof self->message - 1);
        std::longjmp(self->jump, 1);
    }
    static void ignore(png_structp, png_const_charp) {}
    static void give(png_structp png, png_bytep out, std::size_t size) {
        auto* const self = static_cast<State*>(png_get_io_ptr(png));
        if (size > self->file.size() - self->offset) png_error(png, "the data ends too early");
        std::memcpy(out, self->file.data() + self->offset, size);
        self->offset += size;
    }

    // libpng leaves by longjmp, so what calls it below holds nothing that needs a destructor.
    bool read_header() {
        if (setjmp(jump)) return false;
        png_read_info(png, info);
        return true;
    }
    bool read_rows(std::uint8_t* out, bool as_rgba) {
        if (setjmp(jump)) return false;
        if (as_rgba) {
            png_set_expand(png);
            png_set_scale_16(png);
            png_set_gray_to_rgb(png);
            png_set_add_alpha(png, 0xFF, PNG_FILLER_AFTER);
        }
        const int passes = png_set_interlace_handling(png);
        png_read_update_info(png, info);
        const png_uint_32 height = png_get_image_height(png, info);
        const std::size_t stride = png_get_rowbytes(png, info);
        if (as_rgba && stride != std::size_t{4} * png_get_image_width(png, info)) png_error(png, "unexpected row size");
        for (int pass = 0; pass < passes; ++pass)
            for (png_uint_32 y = 0; y < height; ++y) png_read_row(png, out + y * stride, nullptr);
        return true;
    }
};

PngReader::PngReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
PngReader::PngReader(PngReader&&) noexcept = default;
PngReader::~PngReader() = default;

Result<PngReader> PngReader::open(std::span<const std::byte> file) {
    auto state = std::make_unique<State>();
    state->file = file;
    state->png = png_create_read_struct(PNG_LIBPNG_VER_STRING, state.get(), State::fail, State::ignore);
    if (state->png) state->info = png_create_info_struct(state->png);
    if (!state->info) return error(ErrorKind::resource_exhausted, "libpng has no memory");
    // What stands beside the picture takes no memory to speak of.
    png_set_chunk_cache_max(state->png, 128);
    png_set_chunk_malloc_max(state->png, 8 << 20);
    png_set_read_fn(state->png, state.get(), State::give);
    PngReader reader(std::move(state));
    if (!reader.state_->read_header()) return std::unexpected(reader.failed().error());
    return reader;
}

Result<void> PngReader::failed() const {
    return error(ErrorKind::invalid_argument, std::string("PNG: ") + state_->message);
}

std::uint32_t PngReader::width() const {
    return png_get_image_width(state_->png, state_->info);
}
std::uint32_t PngReader::height() const {
    return png_get_image_height(state_->png, state_->info);
}
int PngReader::bit_depth() const {
    return png_get_bit_depth(state_->png, state_->info);
}
bool PngReader::is_gray() const {
    return png_get_color_type(state_->png, state_->info) == PNG_COLOR_TYPE_GRAY;
}
std::size_t PngReader::row_bytes() const {
    return png_get_rowbytes(state_->png, state_->info);
}

Result<void> PngReader::read_rgba(std::uint8_t* pixels) {
    return state_->read_rows(pixels, true) ? Result<void>() : failed();
}
Result<void> PngReader::read_stored(std::uint8_t* rows) {
    return state_->read_rows(rows, false) ? Result<void>() : failed();
}

}  // namespace camrig::world
