#include "core/fault/sending.h"

#include <algorithm>
#include <cmath>

namespace camrig::fault {
namespace {

/// Numbers of one fault and frame.
enum Salt : std::uint64_t { whether, where, packet_number, slice_number, order };

/// The first byte of the picture's entropy-coded data: what follows the header of SOS (ITU-T T.81, B.2.3); 0: none.
std::size_t data_begin(std::span<const std::byte> jpeg) {
    std::size_t at = 2;
    while (at + 4 <= jpeg.size()) {
        if (jpeg[at] != std::byte{0xFF}) return 0;
        const auto marker = std::to_integer<int>(jpeg[at + 1]);
        const std::size_t length =
            std::to_integer<std::size_t>(jpeg[at + 2]) << 8 | std::to_integer<std::size_t>(jpeg[at + 3]);
        at += 2 + length;
        if (marker == 0xDA) return at <= jpeg.size() ? at : 0;
    }
    return 0;
}

void damage(const Fault& fault, const FrameKey& frame, const CorruptJpeg& how, std::vector<std::byte>& jpeg) {
    const auto counter = static_cast<std::uint64_t>(frame.sequence);
    if (chance(fault, counter, whether) >= how.probability) return;
    const std::size_t begin = how.keep_header ? data_begin(jpeg) : 0;
    const std::size_t room = jpeg.size() - begin;
    const auto amount =
        std::min(static_cast<std::size_t>(std::ceil(fault.severity * static_cast<double>(how.amount))), room);
    if (amount == 0) return;
    // A run of bytes ends where it does at every severity.
    const std::size_t most = std::min(static_cast<std::size_t>(how.amount), room);
    const std::size_t end =
        begin + most + static_cast<std::size_t>(chance(fault, counter, where) * static_cast<double>(room - most + 1));
    const auto from = jpeg.begin() + static_cast<std::ptrdiff_t>(end - amount);
    switch (how.mode) {
        case Damage::truncate:
            jpeg.resize(jpeg.size() - amount);
            break;
        case Damage::truncate_eoi:
            jpeg.resize(jpeg.size() - amount);
            jpeg.insert(jpeg.end(), {std::byte{0xFF}, std::byte{0xD9}});
            break;
        case Damage::bitflip:
            for (std::size_t i = 0; i < amount; ++i) {
                const auto bit =
                    static_cast<std::size_t>(chance(fault, counter << 24 | i, where) * static_cast<double>(8 * room));
                jpeg[begin + bit / 8] ^= std::byte{1} << (bit % 8);
            }
            break;
        case Damage::zero:
            std::fill_n(from, amount, std::byte{0});
            break;
        case Damage::cut:
            jpeg.erase(from, from + static_cast<std::ptrdiff_t>(amount));
            break;
    }
}

}  // namespace

bool is_stalled(const FrameFaults& faults, std::string_view output) {
    return std::ranges::any_of(faults.active, [&](const FaultRef& one) {
        const auto* const stall = std::get_if<Stall>(&one->kind);
        return stall && is_for(stall->output, output) && is_in_period(*one, faults.frame.world_ns, stall->period_s);
    });
}

bool is_disconnected(const FrameFaults& faults, std::string_view output) {
    if (output == to_string(Output::v4l2)) return false;
    return std::ranges::any_of(faults.active, [&](const FaultRef& one) {
        const auto acts = [&](const auto* fault) {
            return fault && is_for(fault->output, output) && is_in_period(*one, faults.frame.world_ns, fault->period_s);
        };
        return acts(std::get_if<Disconnect>(&one->kind)) || acts(std::get_if<Restart>(&one->kind));
    });
}

std::optional<std::vector<std::byte>> damaged_jpeg(const FrameFaults& faults, std::string_view output,
                                                   std::span<const std::byte> jpeg) {
    std::optional<std::vector<std::byte>> damaged;
    for (const FaultRef& one : faults.active) {
        const auto* const how = std::get_if<CorruptJpeg>(&one->kind);
        if (!how || !is_for(how->output, output)) continue;
        if (!damaged) damaged.emplace(jpeg.begin(), jpeg.end());
        damage(*one, faults.frame, *how, *damaged);
    }
    if (damaged && std::ranges::equal(*damaged, jpeg)) return std::nullopt;
    return damaged;
}

bool is_cut(const FrameFaults& faults) {
    return std::ranges::any_of(faults.active, [&](const FaultRef& one) {
        const auto* const cut = std::get_if<CutPart>(&one->kind);
        return cut &&
               chance(*one, static_cast<std::uint64_t>(faults.frame.sequence)) < cut->probability * one->severity;
    });
}

int packet_distance(const FrameFaults& faults, std::uint64_t packet) {
    std::int64_t distance = 0;
    for (const FaultRef& one : faults.active) {
        const auto* const how = std::get_if<PacketReorder>(&one->kind);
        if (how && chance(*one, packet, order) < how->probability * one->severity)
            distance = std::max(distance, how->distance);
    }
    return static_cast<int>(distance);
}

std::uint64_t ssrc_epoch(const FrameFaults& faults) {
    std::uint64_t epoch = 0;
    for (const FaultRef& one : faults.active)
        if (const auto* const how = std::get_if<NewSsrc>(&one->kind)) {
            const double since_s = static_cast<double>(faults.frame.world_ns - one->begin_ns) * 1e-9;
            epoch += one->id << 32 | static_cast<std::uint32_t>(since_s * one->severity / how->period_s);
        }
    return epoch;
}

std::optional<ImageSize> other_size(const FrameFaults& faults, std::string_view output, ImageSize size) {
    ImageSize sent = size;
    for (const FaultRef& one : faults.active) {
        const auto* const how = std::get_if<OtherSize>(&one->kind);
        if (!how || !is_for(how->output, output) ||
            chance(*one, static_cast<std::uint64_t>(faults.frame.sequence)) >= how->probability)
            continue;
        const auto smaller = [&](int pixels, int least) {
            return std::max(least, static_cast<int>(std::lround(pixels * (1.0 - one->severity * how->share))));
        };
        sent = {std::min(sent.width, smaller(size.width, min_image_size.width)),
                std::min(sent.height, smaller(size.height, min_image_size.height))};
    }
    return sent == size ? std::nullopt : std::optional(sent);
}

bool is_packet_lost(const FrameFaults& faults, std::uint64_t packet) {
    return std::ranges::any_of(faults.active, [&](const FaultRef& one) {
        const auto* const loss = std::get_if<PacketLoss>(&one->kind);
        return loss && chance(*one, packet, packet_number) < loss->probability * one->severity;
    });
}

namespace {

bool happens(const Fault& fault, const FrameFaults& faults, double probability) {
    return chance(fault, static_cast<std::uint64_t>(faults.frame.sequence)) < probability * fault.severity;
}

/// A number for each slice of each frame.
std::uint64_t slice_key(const FrameFaults& faults, std::uint64_t index) {
    return static_cast<std::uint64_t>(faults.frame.sequence) << 12 | (index & 0xFFF);
}

}  // namespace

std::optional<PartError> part_error(const FrameFaults& faults) {
    for (const FaultRef& one : faults.active)
        if (const auto* const bad = std::get_if<BadPart>(&one->kind); bad && happens(*one, faults, bad->probability))
            return bad->mode;
    return std::nullopt;
}

bool is_slice_dropped(const FrameFaults& faults, std::uint64_t index, bool is_key) {
    return std::ranges::any_of(faults.active, [&](const FaultRef& one) {
        const auto* const how = std::get_if<CorruptVideo>(&one->kind);
        if (!how) return false;
        if (how->mode == VideoDamage::drop_idr) return is_key && happens(*one, faults, how->probability);
        return how->mode == VideoDamage::drop_nal &&
               chance(*one, slice_key(faults, index), slice_number) < how->probability * one->severity;
    });
}

void damage_slice(const FrameFaults& faults, std::uint64_t index, std::span<std::byte> payload) {
    for (const FaultRef& one : faults.active) {
        const auto* const how = std::get_if<CorruptVideo>(&one->kind);
        if (!how || how->mode != VideoDamage::bitflip || payload.empty()) continue;
        const std::uint64_t key = slice_key(faults, index);
        if (chance(*one, key, slice_number) >= how->probability) continue;
        const auto flips = static_cast<std::uint64_t>(std::ceil(one->severity * static_cast<double>(how->amount)));
        for (std::uint64_t i = 0; i < flips; ++i) {
            const auto bit =
                static_cast<std::size_t>(chance(*one, key << 20 | i, where) * static_cast<double>(8 * payload.size()));
            const std::byte flipped = payload[bit / 8] ^ (std::byte{1} << (bit % 8));
            // Start codes and emulation prevention (ITU-T H.264, 7.4.1) are made of bytes up to 3.
            if (flipped > std::byte{3}) payload[bit / 8] = flipped;
        }
    }
}

bool has_buffer_error(const FrameFaults& faults) {
    return std::ranges::any_of(faults.active, [&](const FaultRef& one) {
        const auto* const error = std::get_if<BufferError>(&one->kind);
        return error && happens(*one, faults, error->probability);
    });
}

std::size_t bytes_kept(const FrameFaults& faults, std::size_t bytes) {
    std::size_t kept = bytes;
    for (const FaultRef& one : faults.active) {
        const auto* const wrong = std::get_if<WrongSize>(&one->kind);
        if (!wrong || chance(*one, static_cast<std::uint64_t>(faults.frame.sequence)) >= wrong->probability) continue;
        const double missing = std::ceil(one->severity * wrong->share * static_cast<double>(bytes));
        kept = std::min(kept, bytes - std::min(bytes, static_cast<std::size_t>(missing)));
    }
    return kept;
}

const Unplug* unplug_of(const FrameFaults& faults) {
    for (const FaultRef& one : faults.active)
        if (const auto* const out = std::get_if<Unplug>(&one->kind);
            out && is_in_period(*one, faults.frame.world_ns, out->period_s))
            return out;
    return nullptr;
}

Result<void> check_sending(const FaultKind& kind) {
    const auto is_of_v4l2 = [](const auto* fault) { return fault && fault->output == Output::v4l2; };
    if (is_of_v4l2(std::get_if<Disconnect>(&kind)) || is_of_v4l2(std::get_if<Restart>(&kind)))
        return error(
            ErrorKind::unsupported,
            "params.output: a v4l2loopback device cannot be unplugged while programs have it open; let it stall "
            "(kind stall), or give the camera a user-space device (output device)");
    if (is_of_v4l2(std::get_if<Refuse>(&kind)))
        return error(ErrorKind::unsupported,
                     "params.output: the kernel opens a v4l2loopback device without asking; give the camera a "
                     "user-space device (output device)");
    return {};
}

}  // namespace camrig::fault
