#include "tools/view/picture.h"

#include <algorithm>
#include <memory>

#include <turbojpeg.h>

namespace camrig::view {
namespace {

constexpr int max_side = 8192;

}  // namespace

Result<Picture> decode_jpeg(std::span<const std::byte> bytes, int most_width) {
    const std::unique_ptr<void, decltype(&::tjDestroy)> decoder(::tjInitDecompress(), &::tjDestroy);
    const auto failed = [&] {
        return error(ErrorKind::internal, std::string("a picture that is no JPEG: ") + ::tjGetErrorStr2(decoder.get()));
    };
    if (!decoder) return error(ErrorKind::resource_exhausted, "no JPEG decoder");
    const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
    int width = 0, height = 0, sampling = 0, space = 0;
    if (::tjDecompressHeader3(decoder.get(), data, bytes.size(), &width, &height, &sampling, &space) != 0)
        return failed();
    if (width < 1 || height < 1 || width > max_side || height > max_side)
        return error(ErrorKind::resource_exhausted, "a picture of more than 8192x8192 pixels");
    tjscalingfactor factor{8, 8};
    while (factor.num > 1 && TJSCALED(width, factor) > most_width) --factor.num;
    Picture picture{TJSCALED(width, factor), TJSCALED(height, factor)};
    picture.rgba.resize(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) * 4);
    if (::tjDecompress2(decoder.get(), data, bytes.size(), picture.rgba.data(), picture.width, 0, picture.height,
                        TJPF_RGBA, 0) != 0)
        return failed();
    return picture;
}

}  // namespace camrig::view
