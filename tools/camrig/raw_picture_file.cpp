#include "tools/camrig/raw_picture_file.h"

#include <fstream>
#include <regex>
#include <span>
#include <string>

#include "core/world/png_reader.h"

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

Result<std::string> bytes_of(const std::filesystem::path& path) {
    std::error_code failed;
    const auto length = std::filesystem::file_size(path, failed);
    if (failed) return refused(path, failed.message());
    if (length > most_file_bytes) return refused(path, "is larger than 1 GiB");
    std::ifstream in(path, std::ios::binary);
    std::string bytes(length, '\0');
    if (!in.read(bytes.data(), static_cast<std::streamsize>(length))) return refused(path, "cannot be read");
    return bytes;
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
    const auto file = bytes_of(path);
    if (!file) return std::unexpected(file.error());
    auto png = world::PngReader::open(std::as_bytes(std::span(*file)));
    if (!png) return refused(path, png.error().message);
    const auto width = png->width(), height = png->height();
    const int depth = png->bit_depth();
    if (!is_side(width) || !is_side(height)) return refused(path, "sides of 1 to 16384 are read");
    if (!png->is_gray() || (depth != 8 && depth != 16))
        return refused(path, "must be a grey PNG of 8 or 16 bits: the raw numbers, not a picture of them");
    const int each = depth / 8;
    std::vector<std::uint8_t> bytes(std::size_t{width} * height * static_cast<std::size_t>(each));
    if (auto good = png->read_stored(bytes.data()); !good) return refused(path, good.error().message);
    std::vector<sensor::RawPicture> one(1);
    one[0] = {path.string(),
              {static_cast<int>(width), static_cast<int>(height)},
              numbers_of(bytes.data(), std::size_t{width} * height, each, true)};
    return one;
}

/// The format of numpy.save, version 1 to 3: magic, version, length of the header, a Python dictionary, the numbers.
Result<std::vector<sensor::RawPicture>> read_npy(const std::filesystem::path& path) {
    const auto file = bytes_of(path);
    if (!file) return std::unexpected(file.error());
    const std::string& bytes = *file;
    const std::size_t length = bytes.size();
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
