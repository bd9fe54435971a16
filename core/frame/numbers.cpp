#include "core/frame/numbers.h"

#include <algorithm>
#include <cstdint>
#include <span>

namespace camrig::frame {

Result<FrameRef> numbers_in(FramePool& pool, const FrameRef& numbers, int bits) {
    const FrameInfo& info = numbers->info();
    if (info.kind != FrameKind::sensor || !info.sensor)
        return error(ErrorKind::unsupported, "this picture has no numbers of a sensor");
    if (bits < 8 || bits > 16)
        return error(ErrorKind::invalid_argument, "numbers of " + std::to_string(bits) + " bits; use 8 to 16");
    const int up = bits - info.sensor->bits;
    if (up == 0 && bits > 8) return numbers;
    FrameInfo made = info;
    made.damage = {};
    made.format = bits == 8 ? PixelFormat::gray8 : info.format;
    const std::shared_ptr<Frame> frame = pool.acquire(std::move(made));
    const std::span from(reinterpret_cast<const std::uint16_t*>(numbers->bytes().data()), numbers->bytes().size() / 2);
    const auto shifted = [up](std::uint16_t number) { return up >= 0 ? number << up : number >> -up; };
    if (bits == 8) {
        std::ranges::transform(from, reinterpret_cast<std::uint8_t*>(frame->mutable_bytes().data()),
                               [&](std::uint16_t number) { return static_cast<std::uint8_t>(shifted(number)); });
    } else {
        std::ranges::transform(from, reinterpret_cast<std::uint16_t*>(frame->mutable_bytes().data()),
                               [&](std::uint16_t number) { return static_cast<std::uint16_t>(shifted(number)); });
    }
    return FrameRef(frame);
}

}  // namespace camrig::frame
