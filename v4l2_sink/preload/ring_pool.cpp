#include "v4l2_sink/preload/ring_pool.h"

#include <algorithm>
#include <cstring>

#include "core/stream/silence.h"

namespace camrig::device {
namespace {

constexpr TimeNs idle_repeat_ns = ns_per_s;

bool same_rate(const camrig_rate& a, const camrig_rate& b) {
    return std::uint64_t{a.num} * b.den == std::uint64_t{b.num} * a.den;
}

}  // namespace

Result<std::shared_ptr<FedRing>> RingPool::take(const std::string& camera, const camrig_format& format,
                                                codec::ChromaSampling mjpg_sampling) {
    const auto stream = bus_.find(camera);
    if (!stream) return std::unexpected(stream.error());
    camrig_format key = format;
    const camrig_rate own{static_cast<std::uint32_t>(stream->rate.num()),
                          static_cast<std::uint32_t>(stream->rate.den())};
    if (same_rate(format.rate, own)) key.rate = {0, 0};

    const auto media = media_format_of(format, mjpg_sampling);
    if (!media) return error(ErrorKind::invalid_argument, "a pixel format that devices do not have");
    std::erase_if(rings_, [](const auto& ring) { return ring.expired(); });
    for (const auto& known : rings_)
        if (auto ring = known.lock(); ring && ring->camera == camera && ring->media == *media &&
                                      std::memcmp(&ring->format, &key, sizeof key) == 0)
            return ring;

    auto ring = std::make_shared<FedRing>();
    ring->camera = camera;
    ring->format = key;
    ring->media = *media;
    if (key.rate.num != 0) {
        const auto lower = Rate::create(key.rate.num, key.rate.den);
        if (!lower) return std::unexpected(lower.error());
        ring->rate = *lower;
    }
    auto memory = DeviceRing::create(media->size, picture_bytes(format), ring->rate);
    if (!memory) return std::unexpected(memory.error());
    ring->ring = std::move(*memory);
    if (auto fed = feed(ring); !fed) return std::unexpected(fed.error());
    rings_.push_back(ring);
    return ring;
}

Result<void> RingPool::feed(const std::shared_ptr<FedRing>& ring) {
    // Rings of one size differ by their rates.
    stream::SubscribeOptions options{
        .kind = "device",
        .peer = "ring " + ring->media.size.to_string() + (ring->rate ? " at " + ring->rate->to_string() + "/s" : ""),
        .rate = ring->rate};
    const auto on_end = [this, tasks = tasks_, weak = std::weak_ptr(ring)](const Error& why) {
        tasks->post([this, weak, is_gone = why.kind == ErrorKind::not_found] {
            if (auto held = weak.lock()) ended(held, is_gone);
        });
    };
    auto subscription = bus_.subscribe(ring->camera, ring->media, std::move(options), ring->ring, on_end);
    if (!subscription) return std::unexpected(subscription.error());
    ring->subscription = std::move(*subscription);
    return {};
}

void RingPool::ended(const std::shared_ptr<FedRing>& ring, bool is_gone) {
    // A camera that changed its size goes on in the reader's size.
    ring->subscription.reset();
    if (is_gone || !feed(ring)) lost_(ring);
}

void RingPool::tick(TimeNs monotonic_ns) {
    if (is_lockstep_ || rings_.empty()) return;
    const auto cameras = bus_.cameras();
    for (const auto& known : rings_) {
        const auto ring = known.lock();
        if (!ring) continue;
        const auto camera = std::ranges::find(cameras, ring->camera, &stream::CameraStream::name);
        if (camera == cameras.end()) continue;
        const TimeNs idle_ns = stream::silence_ns(camera->rate, idle_repeat_ns);
        ring->ring->repeat_if_idle(monotonic_ns, ring->rate ? stream::silence_ns(*ring->rate, idle_ns) : idle_ns);
    }
}

}  // namespace camrig::device
