#include "control/unrealcv/pictures.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <span>
#include <string>

#include "core/camera/lens_map.h"

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

using Bytes = std::vector<std::byte>;

void append(Bytes& out, std::span<const std::byte> bytes) {
    out.insert(out.end(), bytes.begin(), bytes.end());
}

void put(Bytes& out, std::size_t at, std::uint32_t value, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i) out[at + i] = static_cast<std::byte>(value >> (8 * i) & 0xffU);
}

/// Several pixels at a time: compilers make no such of a loop over one at our level of optimisation.
using Words = std::uint32_t __attribute__((vector_size(32)));

/// Red and blue change places; it is opaque. A pixel's bytes in their order are those of its word from the lowest.
template <typename Word>
void make_bgra(const std::byte* rgba, std::byte* to) {
    Word word;
    std::memcpy(&word, rgba, sizeof word);
    word = (word & 0xff00U) | (word >> 16 & 0xffU) | (word & 0xffU) << 16 | 0xff000000U;
    std::memcpy(to, &word, sizeof word);
}
static_assert(std::endian::native == std::endian::little);

codec::BytesRef npy(PictureMemory& memory, std::string_view type, const std::string& shape,
                    std::span<const std::byte> values) {
    const auto out = memory.file();
    const std::string head = npy_head(type, shape);
    out->reserve(head.size() + values.size());
    append(*out, std::as_bytes(std::span(head)));
    append(*out, values);
    return out;
}

/// A bitmap of 32 bits a pixel, rows from the top (BITMAPFILEHEADER, BITMAPINFOHEADER). With alpha 255 it is never
/// UTF-8, which the client would take for text.
codec::BytesRef encode_bmp(PictureMemory& memory, const frame::Frame& rgba) {
    constexpr std::size_t head = 54;
    const ImageSize size = rgba.info().size;
    const auto pixels = static_cast<std::size_t>(size.pixels());
    const auto file = memory.file();
    Bytes& out = *file;
    out.resize(head + 4 * pixels);
    out[0] = std::byte{'B'};
    out[1] = std::byte{'M'};
    put(out, 2, static_cast<std::uint32_t>(out.size()), 4);
    put(out, 10, head, 4);
    put(out, 14, 40, 4);
    put(out, 18, static_cast<std::uint32_t>(size.width), 4);
    put(out, 22, static_cast<std::uint32_t>(-size.height), 4);
    put(out, 26, 1, 2);
    put(out, 28, 32, 2);
    put(out, 34, static_cast<std::uint32_t>(4 * pixels), 4);
    const std::byte* const from = rgba.bytes().data();
    std::byte* const to = out.data() + head;
    std::size_t i = 0;
    for (; i + sizeof(Words) <= 4 * pixels; i += sizeof(Words)) make_bgra<Words>(from + i, to + i);
    for (; i < 4 * pixels; i += 4) make_bgra<std::uint32_t>(from + i, to + i);
    return file;
}

/// rgba8 with the size of another frame, to be filled.
std::shared_ptr<frame::Frame> rgba_like(PictureMemory& memory, const frame::Frame& like) {
    frame::FrameInfo info = like.info();
    info.kind = frame::FrameKind::color;
    info.format = frame::PixelFormat::rgba8;
    return memory.frame(std::move(info));
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

Result<codec::BytesRef> PictureMemory::png(const frame::Frame& rgba) {
    std::unique_ptr<codec::Encoder> encoder;
    {
        const std::lock_guard lock(mutex_);
        if (!encoders_.empty()) {
            encoder = std::move(encoders_.back());
            encoders_.pop_back();
        }
    }
    if (!encoder) {
        auto made = codec::create_png_encoder(1, true);
        if (!made) return std::unexpected(made.error());
        encoder = std::move(*made);
    }
    auto bytes = encoder->encode(rgba);
    const std::lock_guard lock(mutex_);
    if (encoders_.size() < max_idle_encoders) encoders_.push_back(std::move(encoder));
    return bytes;
}

Result<codec::BytesRef> encode_picture(PictureMemory& memory, const frame::Frame& rgba, FileType type) {
    if (type == FileType::bmp) return encode_bmp(memory, rgba);
    if (type == FileType::png) return memory.png(rgba);
    return npy(memory, "|u1", shape_of(rgba.info().size) + ", 4", rgba.bytes());
}

frame::FrameRef mask_of(PictureMemory& memory, const frame::Frame& ids, const Colors& colors) {
    const auto mask = rgba_like(memory, ids);
    const auto* in = reinterpret_cast<const std::uint32_t*>(ids.bytes().data());
    auto* out = reinterpret_cast<std::uint8_t*>(mask->mutable_bytes().data());
    std::uint32_t last = 0;
    std::array<std::uint8_t, 4> color{0, 0, 0, 255};
    for (std::size_t i = 0; i < static_cast<std::size_t>(ids.info().size.pixels()); ++i) {
        if (in[i] != last) {
            last = in[i];
            const Rgb rgb = last == 0 ? Rgb{} : colors.of(ObjectId{last});
            std::ranges::copy(rgb, color.begin());
        }
        std::memcpy(out + 4 * i, color.data(), color.size());
    }
    return mask;
}

frame::FrameRef shown_normals(PictureMemory& memory, const frame::Frame& normals,
                              const glm::dmat3& world_from_optical) {
    const auto shown = rgba_like(memory, normals);
    const auto* in = reinterpret_cast<const float*>(normals.bytes().data());
    auto* out = reinterpret_cast<std::uint8_t*>(shown->mutable_bytes().data());
    for (std::size_t i = 0; i < static_cast<std::size_t>(normals.info().size.pixels()); ++i) {
        const glm::dvec3 n = world_from_optical * glm::dvec3(in[3 * i], in[3 * i + 1], in[3 * i + 2]);
        const glm::dvec3 mirrored(n.x, -n.y, n.z);
        out[4 * i + 3] = 255;
        for (int c = 0; c < 3; ++c)
            out[4 * i + static_cast<std::size_t>(c)] =
                static_cast<std::uint8_t>(std::clamp(std::floor((mirrored[c] + 1.0) * 127.5 + 0.5), 0.0, 255.0));
    }
    return shown;
}

frame::FrameRef shown_flow(PictureMemory& memory, const frame::Frame& flow) {
    const auto shown = rgba_like(memory, flow);
    const auto* in = reinterpret_cast<const float*>(flow.bytes().data());
    auto* out = reinterpret_cast<std::uint8_t*>(shown->mutable_bytes().data());
    for (std::size_t i = 0; i < static_cast<std::size_t>(flow.info().size.pixels()); ++i) {
        const float right = in[2 * i], down = in[2 * i + 1];
        out[4 * i + 3] = 255;
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

codec::BytesRef flow_array(PictureMemory& memory, const frame::Frame& flow) {
    return npy(memory, "<f4", shape_of(flow.info().size) + ", 2", flow.bytes());
}

Result<codec::BytesRef> depth_array(PictureMemory& memory, const frame::Frame& depth, Depth how,
                                    const camera::Intrinsics& intrinsics, const camera::Lens& lens) {
    const auto map = camera::LensMap::create(lens);
    if (!map) return std::unexpected(map.error());
    const ImageSize size = depth.info().size;
    const auto* in = reinterpret_cast<const float*>(depth.bytes().data());
    const auto file = memory.file();
    Bytes& out = *file;
    const std::string head = npy_head("<f4", shape_of(size));
    append(out, std::as_bytes(std::span(head)));
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
    return file;
}

}  // namespace camrig::unrealcv
