#include "tools/camrig/raw_picture_file.h"

#include <array>
#include <csetjmp>
#include <cstring>
#include <fstream>
#include <memory>
#include <regex>
#include <string>

#include <png.h>

namespace camrig::cli {
namespace {

constexpr std::size_t most_file_bytes = std::size_t{1} << 30;
constexpr int most_side = 16384;

std::unexpected<Error> refused(const std::filesystem::path& file, const std::string& why) {
    return error(ErrorKind::invalid_argument, file.string() + ": " + why);
}

bool is_side(long long value) {
    return value >= 1 && value <= most_side;
}

struct File {
    void operator()(std::FILE* file) const { std::fclose(file); }
};

struct PngRead {
    char message[160] = "";
    std::jmp_buf jump{};
};

void png_failed(png_structp png, png_const_charp message) {
    auto* read = static_cast<PngRead*>(png_get_error_ptr(png));
    std::strncpy(read->message, message, sizeof read->message - 1);
    std::longjmp(read->jump, 1);
}

void png_ignore(png_structp, png_const_charp) {}

// libpng leaves by longjmp, so the two halves below hold nothing that needs a destructor.
bool png_header(png_structp png, png_infop info, PngRead& read, std::FILE* file) {
    if (setjmp(read.jump)) return false;
    png_init_io(png, file);
    png_read_info(png, info);
    return true;
}

bool png_rows(png_structp png, png_infop info, PngRead& read, std::uint8_t* out) {
    if (setjmp(read.jump)) return false;
    const int passes = png_set_interlace_handling(png);
    png_read_update_info(png, info);
    const png_uint_32 height = png_get_image_height(png, info);
    for (int pass = 0; pass < passes; ++pass)
        for (png_uint_32 y = 0; y < height; ++y) png_read_row(png, out + y * png_get_rowbytes(png, info), nullptr);
    return true;
}

/// Numbers of one or two bytes each, as they lie in a file.
std::vector<std::uint16_t> numbers_of(const std::uint8_t* bytes, std::size_t count, int bytes_each, bool big_endian) {
    std::vector<std::uint16_t> numbers(count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint8_t* const at = bytes + i * static_cast<std::size_t>(bytes_each);
        if (bytes_each == 1)
            numbers[i] = at[0];
        else
            numbers[i] = static_cast<std::uint16_t>(big_endian ? at[0] << 8 | at[1] : at[1] << 8 | at[0]);
    }
    return numbers;
}

Result<std::vector<sensor::RawPicture>> read_png(const std::filesystem::path& path) {
    const std::unique_ptr<std::FILE, File> file(std::fopen(path.c_str(), "rb"));
    if (!file) return refused(path, std::strerror(errno));
    PngRead read;
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &read, png_failed, png_ignore);
    CHECK(png != nullptr);
    struct Ended {
        png_structp png;
        png_infop info;
        ~Ended() { png_destroy_read_struct(&png, &info, nullptr); }
    } held{png, png_create_info_struct(png)};
    if (!png_header(png, held.info, read, file.get())) return refused(path, read.message);
    const auto width = png_get_image_width(png, held.info), height = png_get_image_height(png, held.info);
    const int depth = png_get_bit_depth(png, held.info);
    if (!is_side(width) || !is_side(height)) return refused(path, "sides of 1 to 16384 are read");
    if (png_get_color_type(png, held.info) != PNG_COLOR_TYPE_GRAY || (depth != 8 && depth != 16))
        return refused(path, "must be a grey PNG of 8 or 16 bits: the raw numbers, not a picture of them");
    const int each = depth / 8;
    std::vector<std::uint8_t> bytes(std::size_t{width} * height * static_cast<std::size_t>(each));
    if (!png_rows(png, held.info, read, bytes.data())) return refused(path, read.message);
    std::vector<sensor::RawPicture> one(1);
    one[0] = {path.string(),
              {static_cast<int>(width), static_cast<int>(height)},
              numbers_of(bytes.data(), std::size_t{width} * height, each, true)};
    return one;
}

/// The format of numpy.save, version 1 to 3: magic, version, length of the header, a Python dictionary, the numbers.
Result<std::vector<sensor::RawPicture>> read_npy(const std::filesystem::path& path) {
    std::error_code failed;
    const auto length = std::filesystem::file_size(path, failed);
    if (failed) return refused(path, failed.message());
    if (length > most_file_bytes) return refused(path, "is larger than 1 GiB");
    std::ifstream in(path, std::ios::binary);
    std::string bytes(length, '\0');
    if (!in.read(bytes.data(), static_cast<std::streamsize>(length))) return refused(path, "cannot be read");
    const auto byte = [&](std::size_t i) { return static_cast<std::size_t>(static_cast<unsigned char>(bytes[i])); };
    if (length < 12 || !bytes.starts_with("\x93NUMPY")) return refused(path, "is no .npy file");
    const bool is_first = byte(6) == 1;
    const std::size_t begin = is_first ? 10 : 12;
    const std::size_t header = byte(8) | byte(9) << 8 | (is_first ? 0 : byte(10) << 16 | byte(11) << 24);
    constexpr std::size_t most_header = 4096;
    if (header > most_header || begin + header > length) return refused(path, "has a header that is cut off");
    const std::string text = bytes.substr(begin, header);
    std::smatch kind, shape;
    static const std::regex kinds("'descr': *'([<>|])u([12])'");
    static const std::regex shapes(R"('shape': *\((?:([0-9]{1,4}), *)?([0-9]{1,5}), *([0-9]{1,5}),?\))");
    if (!std::regex_search(text, kind, kinds) || !std::regex_search(text, shape, shapes) ||
        text.find("'fortran_order': True") != std::string::npos)
        return refused(path, "must hold uint8 or uint16 of shape (height, width) or (pictures, height, width)");
    const int each = kind[2] == "1" ? 1 : 2;
    const long long count = shape[1].matched ? std::stoll(shape[1]) : 1;
    const long long height = std::stoll(shape[2]), width = std::stoll(shape[3]);
    if (!is_side(width) || !is_side(height)) return refused(path, "sides of 1 to 16384 are read");
    const auto pixels = static_cast<std::size_t>(width * height);
    if (begin + header + static_cast<std::size_t>(count) * pixels * static_cast<std::size_t>(each) != length)
        return refused(path, "has another length than its header says");
    std::vector<sensor::RawPicture> pictures;
    const auto* at = reinterpret_cast<const std::uint8_t*>(bytes.data()) + begin + header;
    for (long long i = 0; i < count; ++i, at += pixels * static_cast<std::size_t>(each))
        pictures.push_back({path.string() + (count > 1 ? " picture " + std::to_string(i) : std::string()),
                            {static_cast<int>(width), static_cast<int>(height)},
                            numbers_of(at, pixels, each, kind[1] == ">")});
    return pictures;
}

}  // namespace

Result<std::vector<sensor::RawPicture>> read_raw_pictures(const std::filesystem::path& file) {
    if (file.extension() == ".png") return read_png(file);
    if (file.extension() == ".npy") return read_npy(file);
    return refused(file, "must end in .png or .npy");
}

}  // namespace camrig::cli
