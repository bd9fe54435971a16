#include "rtsp_out/http/npy.h"

#include <bit>

namespace camrig::http {

static_assert(std::endian::native == std::endian::little, "the pixels are sent as they lie in memory");

std::string npy_float32_head(ImageSize size, int channels) {
    constexpr std::size_t alignment = 64;
    constexpr std::size_t prefix = 10;  // magic, version, length of the dictionary
    std::string dictionary = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::to_string(size.height) +
                             ", " + std::to_string(size.width) +
                             (channels == 1 ? "" : ", " + std::to_string(channels)) + "), }";
    const std::size_t used = prefix + dictionary.size() + 1;
    dictionary.append((alignment - used % alignment) % alignment, ' ');
    dictionary += '\n';
    std::string head("\x93NUMPY\x01\x00", 8);
    head += static_cast<char>(dictionary.size() & 0xff);
    head += static_cast<char>(dictionary.size() >> 8);
    return head + dictionary;
}

}  // namespace camrig::http
