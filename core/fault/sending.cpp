#include "core/fault/sending.h"

#include <algorithm>
#include <cmath>

namespace camrig::fault {
namespace {

/// Numbers of one fault and frame.
enum Salt : std::uint64_t { whether, where, packet_number, slice_number, order, delayed, delay };

bool happens(const Fault& fault, const FrameFaults& faults, double probability) {
    return chance(fault, static_cast<std::uint64_t>(faults.frame.sequence)) < probability * fault.severity;
}

std::string_view mode_of(const FaultKind& kind) {
    if (const auto* const how = std::get_if<CorruptJpeg>(&kind)) return to_string(how->mode);
    if (const auto* const how = std::get_if<CorruptVideo>(&kind)) return to_string(how->mode);
    const bool is_lost = std::holds_alternative<PacketLoss>(kind) || std::holds_alternative<Bandwidth>(kind);
    return is_lost ? "lost" : to_string(Damage::truncate);
}

/// Nothing yet, of a picture of so many bytes.
Harm harm_by(const Fault& fault, std::size_t size) {
    return {.fault = fault.id, .kind = name_of(fault.kind), .mode = mode_of(fault.kind), .size = size, .first = {}};
}

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

/// What it did; of none of the bytes: nothing. RTP carries no header (RFC 2435, 3): what sends it would only fail at a
/// wrong one, as GStreamer's payloader crashes at a length beyond the picture's end.
Harm damage(const Fault& fault, const FrameKey& frame, const CorruptJpeg& how, std::string_view output,
            std::vector<std::byte>& jpeg) {
    Harm harm = harm_by(fault, jpeg.size());
    const auto counter = static_cast<std::uint64_t>(frame.sequence);
    if (chance(fault, counter, whether) >= how.probability) return harm;
    const bool keeps_header = how.keep_header || output == to_string(Output::rtsp);
    const std::size_t begin = keeps_header ? data_begin(jpeg) : 0;
    const std::size_t room = jpeg.size() - begin;
    const auto amount =
        std::min(static_cast<std::size_t>(std::ceil(fault.severity * static_cast<double>(how.amount))), room);
    if (amount == 0) return harm;
    // A run of bytes ends where it does at every severity.
    const std::size_t most = std::min(static_cast<std::size_t>(how.amount), room);
    const std::size_t end =
        begin + most + static_cast<std::size_t>(chance(fault, counter, where) * static_cast<double>(room - most + 1));
    const auto from = jpeg.begin() + static_cast<std::ptrdiff_t>(end - amount);
    switch (how.mode) {
        case Damage::truncate:
            harm.add(jpeg.size() - amount, amount);
            jpeg.resize(jpeg.size() - amount);
            break;
        case Damage::truncate_eoi:
            harm.add(jpeg.size() - amount, amount);
            jpeg.resize(jpeg.size() - amount);
            jpeg.insert(jpeg.end(), {std::byte{0xFF}, std::byte{0xD9}});
            break;
        case Damage::bitflip: {
            const std::vector<std::byte> before = jpeg;
            for (std::size_t i = 0; i < amount; ++i) {
                const auto bit =
                    static_cast<std::size_t>(chance(fault, counter << 24 | i, where) * static_cast<double>(8 * room));
                jpeg[begin + bit / 8] ^= std::byte{1} << (bit % 8);
            }
            harm.add_changes(before, jpeg, 0);
            break;
        }
        case Damage::zero: {
            const std::vector<std::byte> before = jpeg;
            std::fill_n(from, amount, std::byte{0});
            harm.add_changes(before, jpeg, 0);
            break;
        }
        case Damage::cut:
            harm.add(end - amount, amount);
            jpeg.erase(from, from + static_cast<std::ptrdiff_t>(amount));
            break;
    }
    return harm;
}

}  // namespace

bool is_stalled(const FrameFaults& faults, std::string_view output) {
    if (output == to_string(Output::device) && unplug_of(faults)) return true;
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

bool is_reset(const FrameFaults& faults, std::string_view output) {
    return std::ranges::any_of(faults.active, [&](const FaultRef& one) {
        const auto* const out = std::get_if<Disconnect>(&one->kind);
        return out && out->reset && is_for(out->output, output) &&
               is_in_period(*one, faults.frame.world_ns, out->period_s);
    });
}

std::optional<Damaged> damaged_jpeg(const FrameFaults& faults, std::string_view output,
                                    std::span<const std::byte> jpeg) {
    std::optional<Damaged> damaged;
    for (const FaultRef& one : faults.active) {
        const auto* const how = std::get_if<CorruptJpeg>(&one->kind);
        if (!how || !is_for(how->output, output)) continue;
        if (!damaged) damaged.emplace(std::vector<std::byte>(jpeg.begin(), jpeg.end()));
        Harm harm = damage(*one, faults.frame, *how, output, damaged->bytes);
        if (harm.bytes > 0) damaged->harms.push_back(std::move(harm));
    }
    if (damaged && damaged->harms.empty()) return std::nullopt;
    return damaged;
}

std::optional<Harm> cut_part(const FrameFaults& faults, std::size_t bytes) {
    for (const FaultRef& one : faults.active) {
        const auto* const cut = std::get_if<CutPart>(&one->kind);
        if (!cut || !happens(*one, faults, cut->probability)) continue;
        Harm harm = harm_by(*one, bytes);
        harm.add(bytes / 2, bytes - bytes / 2);
        return harm;
    }
    return std::nullopt;
}

Harm whole_loss(const Fault& fault, std::size_t bytes) {
    Harm harm = harm_by(fault, bytes);
    harm.add(0, bytes);
    return harm;
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

TimeNs packet_delay_ns(const FrameFaults& faults, std::uint64_t packet) {
    TimeNs longest_ns = 0;
    for (const FaultRef& one : faults.active) {
        const auto* const how = std::get_if<PacketDelay>(&one->kind);
        if (!how || chance(*one, packet, delayed) >= how->probability * one->severity) continue;
        const double delay_s = how->delay_s + how->jitter_s * chance(*one, packet, delay);
        longest_ns = std::max<TimeNs>(longest_ns, std::llround(1e9 * delay_s));
    }
    return longest_ns;
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

const Fault* packet_loser(const FrameFaults& faults, std::uint64_t packet) {
    const auto found = std::ranges::find_if(faults.active, [&](const FaultRef& one) {
        const auto* const loss = std::get_if<PacketLoss>(&one->kind);
        return loss && chance(*one, packet, packet_number) < loss->probability * one->severity;
    });
    return found == faults.active.end() ? nullptr : found->get();
}

namespace {

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

const Fault* slice_dropper(const FrameFaults& faults, std::uint64_t index, bool is_key) {
    const auto found = std::ranges::find_if(faults.active, [&](const FaultRef& one) {
        const auto* const how = std::get_if<CorruptVideo>(&one->kind);
        if (!how) return false;
        if (how->mode == VideoDamage::drop_idr) return is_key && happens(*one, faults, how->probability);
        return how->mode == VideoDamage::drop_nal &&
               chance(*one, slice_key(faults, index), slice_number) < how->probability * one->severity;
    });
    return found == faults.active.end() ? nullptr : found->get();
}

Harm& harm_of(std::vector<Harm>& harms, const Fault& fault, std::size_t size) {
    const auto found = std::ranges::find(harms, fault.id, &Harm::fault);
    return found == harms.end() ? harms.emplace_back(harm_by(fault, size)) : *found;
}

void damage_slice(const FrameFaults& faults, std::uint64_t index, std::span<std::byte> payload, std::size_t offset,
                  std::size_t size, std::vector<Harm>& harms) {
    for (const FaultRef& one : faults.active) {
        const auto* const how = std::get_if<CorruptVideo>(&one->kind);
        if (!how || how->mode != VideoDamage::bitflip || payload.empty()) continue;
        const std::uint64_t key = slice_key(faults, index);
        if (chance(*one, key, slice_number) >= how->probability) continue;
        const std::vector<std::byte> before(payload.begin(), payload.end());
        const auto flips = static_cast<std::uint64_t>(std::ceil(one->severity * static_cast<double>(how->amount)));
        for (std::uint64_t i = 0; i < flips; ++i) {
            const auto bit =
                static_cast<std::size_t>(chance(*one, key << 20 | i, where) * static_cast<double>(8 * payload.size()));
            const std::byte flipped = payload[bit / 8] ^ (std::byte{1} << (bit % 8));
            // Start codes and emulation prevention (ITU-T H.264, 7.4.1) are made of bytes up to 3.
            if (flipped > std::byte{3}) payload[bit / 8] = flipped;
        }
        harm_of(harms, *one, size).add_changes(before, payload, offset);
    }
}

bool has_buffer_error(const FrameFaults& faults) {
    return std::ranges::any_of(faults.active, [&](const FaultRef& one) {
        const auto* const error = std::get_if<BufferError>(&one->kind);
        return error && happens(*one, faults, error->probability);
    });
}

std::optional<Harm> bytes_missing(const FrameFaults& faults, std::size_t bytes) {
    std::optional<Harm> most;
    for (const FaultRef& one : faults.active) {
        const auto* const wrong = std::get_if<WrongSize>(&one->kind);
        if (!wrong || chance(*one, static_cast<std::uint64_t>(faults.frame.sequence)) >= wrong->probability) continue;
        const double missing = std::ceil(one->severity * wrong->share * static_cast<double>(bytes));
        const std::size_t count = std::min(bytes, static_cast<std::size_t>(missing));
        if (count == 0 || (most && most->bytes >= count)) continue;
        most = harm_by(*one, bytes);
        most->add(bytes - count, count);
    }
    return most;
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
