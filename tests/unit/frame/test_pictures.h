#pragma once

#include <memory>
#include <string>

#include "core/base/random.h"
#include "core/frame/frame.h"

namespace camrig::frame::test {

inline FrameInfo frame_info(ImageSize size, PixelFormat format = PixelFormat::rgba8) {
    FrameInfo info;
    info.camera_id = CameraId{7};
    info.camera = std::make_shared<const std::string>("lobby");
    info.sequence = 42;
    info.world_ns = 1'680'000'000;
    info.size = size;
    info.format = format;
    return info;
}

/// Every byte from its place, without order.
inline Frame noise(ImageSize size, PixelFormat format = PixelFormat::rgba8, std::uint64_t seed = 1) {
    std::vector<std::byte> bytes(bytes_of(format, size));
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i, bits >>= 8) {
        if (i % 8 == 0) bits = random_bits(seed, 0, i);
        bytes[i] = static_cast<std::byte>(bits);
    }
    return Frame(frame_info(size, format), std::move(bytes));
}

/// A smooth picture, as a camera would see: a colour ramp with a soft wave on it.
inline Frame smooth(ImageSize size) {
    std::vector<std::byte> bytes(bytes_of(PixelFormat::rgba8, size));
    std::size_t i = 0;
    for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
            const int ramp_x = 40 + 170 * x / size.width;
            const int ramp_y = 40 + 170 * y / size.height;
            bytes[i++] = static_cast<std::byte>(ramp_x);
            bytes[i++] = static_cast<std::byte>(ramp_y);
            bytes[i++] = static_cast<std::byte>(255 - (ramp_x + ramp_y) / 2);
            bytes[i++] = std::byte{255};
        }
    }
    return Frame(frame_info(size), std::move(bytes));
}

inline int code(std::byte b) {
    return std::to_integer<int>(b);
}

}  // namespace camrig::frame::test
