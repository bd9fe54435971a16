#include "control/unrealcv/pictures.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "core/camera/lens_map.h"
#include "core/codec/encoder.h"

namespace camrig::unrealcv {
namespace {

/// The header of a NumPy file, format version 1.0 (numpy.lib.format): what follows begins at a multiple of 64.
std::string npy_head(std::string_view type, const std::string& shape) {
    std::string dictionary =
        "{'descr': '" + std::string(type) + "', 'fortran_order': False, 'shape': (" + shape + "), }";
    constexpr std::size_t before = 10;
    dictionary.append(63 - (before + dictionary.size()) % 64, ' ');
    dictionary += '\n';
    std::string head("\x93NUMPY\x01\x00", 8);
    head.push_back(static_cast<char>(dictionary.size() & 0xff));
    head.push_back(static_cast<char>(dictionary.size() >> 8));
    return head + dictionary;
}

std::string shape_of(ImageSize size) {
    return std::to_string(size.height) + ", " + std::to_string(size.width);
}

void put(std::string& out, std::size_t at, std::uint32_t value, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i) out[at + i] = static_cast<char>(value >> (8 * i) & 0xffU);
}

/// A bitmap of 32 bits a pixel, rows from the top (BITMAPFILEHEADER, BITMAPINFOHEADER). With alpha 255 it is never
/// UTF-8, which the client would take for text.
std::string encode_bmp(const frame::Frame& rgba) {
    constexpr std::size_t head = 54;
    const ImageSize size = rgba.info().size;
    const auto pixels = static_cast<std::size_t>(size.pixels());
    std::string out(head + 4 * pixels, '\0');
    out[0] = 'B';
    out[1] = 'M';
    put(out, 2, static_cast<std::uint32_t>(out.size()), 4);
    put(out, 10, head, 4);
    put(out, 14, 40, 4);
    put(out, 18, static_cast<std::uint32_t>(size.width), 4);
    put(out, 22, static_cast<std::uint32_t>(-size.height), 4);
    put(out, 26, 1, 2);
    put(out, 28, 32, 2);
    put(out, 34, static_cast<std::uint32_t>(4 * pixels), 4);
    const auto* in = reinterpret_cast<const std::uint8_t*>(rgba.bytes().data());
    auto* to = reinterpret_cast<std::uint8_t*>(out.data()) + head;
    for (std::size_t i = 0; i < 4 * pixels; i += 4) {
        to[i] = in[i + 2];
        to[i + 1] = in[i + 1];
        to[i + 2] = in[i];
        to[i + 3] = 255;
    }
    return out;
}

Result<std::string> encode_png(const frame::Frame& rgba) {
    auto encoder = codec::create_png_encoder(1, true);
    if (!encoder) return std::unexpected(encoder.error());
    const auto bytes = (*encoder)->encode(rgba);
    if (!bytes) return std::unexpected(bytes.error());
    return std::string(reinterpret_cast<const char*>((*bytes)->data()), (*bytes)->size());
}

/// rgba8 with the size of another frame; alpha is 255 everywhere.
std::shared_ptr<frame::Frame> blank(const frame::Frame& like) {
    frame::FrameInfo info = like.info();
    info.kind = frame::FrameKind::color;
    info.format = frame::PixelFormat::rgba8;
    std::vector<std::byte> bytes(static_cast<std::size_t>(info.size.pixels()) * 4, std::byte{255});
    return std::make_shared<frame::Frame>(std::move(info), std::move(bytes));
}

}  // namespace

std::optional<FileType> file_type(std::string_view ending) {
    std::string lower(ending);
    std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (lower == "png") return FileType::png;
    if (lower == "bmp") return FileType::bmp;
    if (lower == "npy") return FileType::npy;
    return std::nullopt;
}

Result<std::string> encode_picture(const frame::Frame& rgba, FileType type) {
    if (type == FileType::bmp) return encode_bmp(rgba);
    if (type == FileType::png) return encode_png(rgba);
    std::string out = npy_head("|u1", shape_of(rgba.info().size) + ", 4");
    return out.append(reinterpret_cast<const char*>(rgba.bytes().data()), rgba.bytes().size());
}

frame::FrameRef mask_of(const frame::Frame& ids, const Colors& colors) {
    const auto mask = blank(ids);
    const auto* in = reinterpret_cast<const std::uint32_t*>(ids.bytes().data());
    auto* out = reinterpret_cast<std::uint8_t*>(mask->mutable_bytes().data());
    std::uint32_t last = 0;
    Rgb color{};
    for (std::size_t i = 0; i < static_cast<std::size_t>(ids.info().size.pixels()); ++i) {
        if (in[i] != last) {
            last = in[i];
            color = last == 0 ? Rgb{} : colors.of(ObjectId{last});
        }
        std::memcpy(out + 4 * i, color.data(), color.size());
    }
    return mask;
}

frame::FrameRef shown_normals(const frame::Frame& normals, const glm::dmat3& world_from_optical) {
    const auto shown = blank(normals);
    const auto* in = reinterpret_cast<const float*>(normals.bytes().data());
    auto* out = reinterpret_cast<std::uint8_t*>(shown->mutable_bytes().data());
    for (std::size_t i = 0; i < static_cast<std::size_t>(normals.info().size.pixels()); ++i) {
        const glm::dvec3 n = world_from_optical * glm::dvec3(in[3 * i], in[3 * i + 1], in[3 * i + 2]);
        const glm::dvec3 mirrored(n.x, -n.y, n.z);
        for (int c = 0; c < 3; ++c)
            out[4 * i + static_cast<std::size_t>(c)] =
                static_cast<std::uint8_t>(std::clamp(std::floor((mirrored[c] + 1.0) * 127.5 + 0.5), 0.0, 255.0));
    }
    return shown;
}

frame::FrameRef shown_flow(const frame::Frame& flow) {
    const auto shown = blank(flow);
    const auto* in = reinterpret_cast<const float*>(flow.bytes().data());
    auto* out = reinterpret_cast<std::uint8_t*>(shown->mutable_bytes().data());
    for (std::size_t i = 0; i < static_cast<std::size_t>(flow.info().size.pixels()); ++i) {
        const float right = in[2 * i], down = in[2 * i + 1];
        const float strength = std::min(1.0f, std::hypot(right, down) / full_flow_px);
        // Sixths of a turn; each channel is on for two of them about its own hue and ramps beside.
        const float hue = std::atan2(down, right) * static_cast<float>(3.0 / std::numbers::pi) + 6.0f;
        for (int c = 0; c < 3; ++c) {
            const float apart = std::abs(std::remainder(hue - 2.0f * static_cast<float>(c), 6.0f));
            const float value = strength * std::clamp(2.0f - apart, 0.0f, 1.0f);
            out[4 * i + static_cast<std::size_t>(c)] =
                std::isnan(value) ? std::uint8_t{0} : static_cast<std::uint8_t>(255.0f * value + 0.5f);
        }
    }
    return shown;
}

std::string flow_array(const frame::Frame& flow) {
    std::string out = npy_head("<f4", shape_of(flow.info().size) + ", 2");
    return out.append(reinterpret_cast<const char*>(flow.bytes().data()), flow.bytes().size());
}

Result<std::string> depth_array(const frame::Frame& depth, Depth how, const camera::Intrinsics& intrinsics,
                                const camera::Lens& lens) {
    const auto map = camera::LensMap::create(lens);
    if (!map) return std::unexpected(map.error());
    const ImageSize size = depth.info().size;
    const auto* in = reinterpret_cast<const float*>(depth.bytes().data());
    std::string out = npy_head("<f4", shape_of(size));
    const std::size_t begin = out.size();
    out.resize(begin + depth.bytes().size());
    const auto ray_length = [&](int x, int y) {
        const glm::dvec2 distorted((x - intrinsics.cx) / intrinsics.fx, (y - intrinsics.cy) / intrinsics.fy);
        const auto ideal = map->is_identity() ? std::optional(distorted) : map->undistort(distorted);
        return ideal ? 1.0 / map->direction_from_ideal(*ideal).z : 1.0;
    };
    for (int y = 0, i = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x, ++i) {
            const double along_axis = in[i];
            double given = how == Depth::plane_cm ? 100.0 * along_axis : along_axis;
            if (how == Depth::ray_m) given *= ray_length(x, y);
            const float value = std::isfinite(in[i]) ? static_cast<float>(given) : depth_of_nothing;
            std::memcpy(out.data() + begin + static_cast<std::size_t>(i) * sizeof value, &value, sizeof value);
        }
    return out;
}

}  // namespace camrig::unrealcv
