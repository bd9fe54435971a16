#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/clock.h"
#include "core/stream/frame_bus.h"

namespace camrig::device {

/// A bus that runs nothing of its own: the test says when a picture comes and when a subscription ends.
class FakeBus final : public stream::FrameBus, public stream::FrameFetcher {
public:
    struct Subscriber {
        std::string camera;
        stream::MediaFormat format;
        std::shared_ptr<stream::Sink> sink;
        std::function<void(Error)> on_end;
        std::shared_ptr<stream::ReaderStats> stats = std::make_shared<stream::ReaderStats>();
        bool is_open = false;
        bool is_there = true;
    };

    Result<stream::Subscription> subscribe(std::string_view camera, const stream::MediaFormat& format,
                                           stream::SubscribeOptions, std::shared_ptr<stream::Sink> sink,
                                           std::function<void(Error)> on_end) override {
        auto subscriber = std::make_shared<Subscriber>();
        subscriber->camera = camera;
        subscriber->format = format;
        subscriber->sink = std::move(sink);
        subscriber->on_end = std::move(on_end);
        subscribers_.push_back(subscriber);
        // The sink stays alive for a while, as in a bus whose worker still has a picture for it.
        return stream::Subscription([subscriber] { subscriber->is_there = false; });
    }
    std::vector<stream::CameraStream> cameras() const override { return {}; }
    Result<stream::CameraStream> find(std::string_view) const override { return error(ErrorKind::not_found, "none"); }
    void add_observer(stream::CameraObserver*) override {}
    void remove_observer(stream::CameraObserver*) override {}
    void note_refused(std::string_view, std::string_view, std::string_view) override {}
    void fetch(stream::FetchRequest request, std::function<void(Result<stream::MediaUnit>)> done) override {
        ++fetches;
        fetched_.emplace_back(std::move(request), std::move(done));
    }

    /// Those who are subscribed now.
    std::vector<std::shared_ptr<Subscriber>> subscribers() const {
        std::vector<std::shared_ptr<Subscriber>> there;
        for (const auto& subscriber : subscribers_)
            if (subscriber->is_there) there.push_back(subscriber);
        return there;
    }
    /// A picture of that format whose bytes all have this value.
    static stream::MediaUnit unit(const stream::MediaFormat& format, std::int64_t sequence, TimeNs monotonic_ns,
                                  std::byte value) {
        stream::MediaUnit unit;
        unit.info.sequence = sequence;
        unit.info.monotonic_ns = monotonic_ns;
        unit.info.size = format.size;
        if (format.codec == codec::Codec::jpeg) {
            unit.bytes = std::make_shared<const std::vector<std::byte>>(100, value);
        } else {
            unit.frame = std::make_shared<const frame::Frame>(
                unit.info, std::vector<std::byte>(bytes_of(format.pixels, format.size), value));
        }
        return unit;
    }
    /// As an Output does it.
    Result<void> publish(std::int64_t sequence, TimeNs monotonic_ns, std::byte value,
                         std::shared_ptr<stream::DeliveryLatch> latch = nullptr) {
        for (const auto& subscriber : subscribers()) {
            if (!std::exchange(subscriber->is_open, true)) {
                stream::StreamInfo info;
                info.stats = subscriber->stats;
                if (auto opened = subscriber->sink->open(info); !opened) return opened;
            }
            stream::MediaUnit picture = unit(subscriber->format, sequence, monotonic_ns, value);
            picture.latch = latch;
            if (auto written = subscriber->sink->write(picture); !written) {
                subscriber->is_there = false;
                subscriber->sink->close();
                subscriber->on_end(written.error());
                return written;
            }
        }
        return {};
    }
    void end_all(const Error& why) {
        for (const auto& subscriber : subscribers()) {
            subscriber->is_there = false;
            subscriber->sink->close();
            subscriber->on_end(why);
        }
    }
    /// Answers what was asked for so far.
    void answer_fetches(std::int64_t sequence, TimeNs monotonic_ns, std::byte value) {
        for (auto& [request, done] : std::exchange(fetched_, {}))
            done(unit(request.format, sequence, monotonic_ns, value));
    }

    int fetches = 0;

private:
    std::vector<std::shared_ptr<Subscriber>> subscribers_;
    std::vector<std::pair<stream::FetchRequest, std::function<void(Result<stream::MediaUnit>)>>> fetched_;
};

}  // namespace camrig::device
