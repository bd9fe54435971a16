#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/base/clock.h"
#include "core/stream/frame_bus.h"

namespace camrig::http {

/// Waits for a condition; false after ten seconds.
inline bool eventually(const std::function<bool()>& condition) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (!condition()) {
        if (std::chrono::steady_clock::now() > deadline) return false;
        std::this_thread::yield();
    }
    return true;
}

inline stream::MediaUnit jpeg_unit(const std::string& camera, std::int64_t sequence, std::size_t size = 100) {
    stream::MediaUnit unit;
    unit.info.camera = std::make_shared<const std::string>(camera);
    unit.info.camera_id = CameraId{1};
    unit.info.sequence = sequence;
    unit.info.world_ns = sequence * 40 * ns_per_ms;
    unit.info.monotonic_ns = monotonic_now_ns();
    unit.info.size = {64, 48};
    std::vector<std::byte> bytes(size, static_cast<std::byte>(sequence));
    bytes.at(0) = std::byte{0xff};
    bytes.at(1) = std::byte{0xd8};
    unit.bytes = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
    return unit;
}

/// A frame bus whose publisher is the test.
class FakeBus final : public stream::FrameBus {
public:
    struct Reader {
        std::string camera;
        stream::MediaFormat format;
        stream::SubscribeOptions options;
        std::shared_ptr<stream::Sink> sink;
        std::function<void(Error)> on_end;
        std::shared_ptr<stream::ReaderStats> stats = std::make_shared<stream::ReaderStats>();
        bool open = false;
    };

    std::atomic<int> refused{0};
    std::vector<stream::CameraStream> known{{CameraId{1}, "lobby", {64, 48}, {}},
                                            {CameraId{2}, "hall", {128, 96}, *Rate::create(30000, 1001)}};

    Result<stream::Subscription> subscribe(std::string_view camera, const stream::MediaFormat& format,
                                           stream::SubscribeOptions options, std::shared_ptr<stream::Sink> sink,
                                           std::function<void(Error)> on_end) override {
        if (auto found = find(camera); !found) return std::unexpected(found.error());
        auto reader = std::make_shared<Reader>();
        reader->camera = camera;
        reader->format = format;
        reader->options = std::move(options);
        reader->sink = std::move(sink);
        reader->on_end = std::move(on_end);
        std::lock_guard lock(mutex_);
        readers_.push_back(reader);
        last_stats = reader->stats;
        last_sink = reader->sink;
        return stream::Subscription([this, reader] {
            std::lock_guard inner(mutex_);
            if (std::erase(readers_, reader) > 0) reader->sink->close();
        });
    }
    std::vector<stream::CameraStream> cameras() const override {
        std::lock_guard lock(mutex_);
        return known;
    }
    Result<stream::CameraStream> find(std::string_view camera) const override {
        std::lock_guard lock(mutex_);
        for (const auto& one : known)
            if (one.name == camera) return one;
        return error(ErrorKind::not_found, "no camera '" + std::string(camera) + "'");
    }
    void add_observer(stream::CameraObserver* observer) override { observer_ = observer; }
    void remove_observer(stream::CameraObserver*) override { observer_ = nullptr; }
    void note_refused(std::string_view, std::string_view, std::string_view) override { ++refused; }
    /// The first camera has other outputs from now on.
    void change(std::vector<OutputSpec> outputs) {
        {
            std::lock_guard lock(mutex_);
            known.front().outputs = std::move(outputs);
        }
        observer_->camera_changed(known.front());
    }

    std::size_t reader_count() const {
        std::lock_guard lock(mutex_);
        return readers_.size();
    }
    std::shared_ptr<Reader> reader(std::size_t index = 0) const {
        std::lock_guard lock(mutex_);
        return readers_.at(index);
    }
    void publish(const stream::MediaUnit& unit) {
        std::lock_guard lock(mutex_);
        for (const auto& reader : readers_) {
            if (reader->camera != *unit.info.camera) continue;
            ++reader->stats->offered;
            if (!std::exchange(reader->open, true)) {
                EXPECT_TRUE(reader->sink->open({unit.info.size, reader->stats}));
            }
            EXPECT_TRUE(reader->sink->write(unit));
        }
    }
    /// The first camera refuses nobody any more.
    void let_in() {
        std::lock_guard lock(mutex_);
        known.front().standing = {};
    }
    /// The camera goes: its sinks are closed and its readers hear of it.
    void end(const std::string& camera) {
        {
            std::lock_guard lock(mutex_);
            std::erase_if(known, [&](const stream::CameraStream& one) { return one.name == camera; });
        }
        throw_out(camera);
    }
    /// Its readers end, as by a fault.
    void throw_out(const std::string& camera) {
        std::vector<std::shared_ptr<Reader>> gone;
        std::lock_guard lock(mutex_);
        std::erase_if(readers_, [&](const auto& reader) {
            if (reader->camera == camera) gone.push_back(reader);
            return reader->camera == camera;
        });
        for (const auto& reader : gone) {
            reader->sink->close();
            if (reader->on_end) reader->on_end({ErrorKind::not_found, "deleted"});
        }
    }

    std::shared_ptr<stream::ReaderStats> last_stats;
    std::weak_ptr<stream::Sink> last_sink;

private:
    stream::CameraObserver* observer_ = nullptr;
    mutable std::mutex mutex_;
    std::vector<std::shared_ptr<Reader>> readers_;
};

/// Answers from `make` at once when it is set; otherwise keeps requests for the test.
class FakeFetcher final : public stream::FrameFetcher {
public:
    using Done = std::function<void(Result<stream::MediaUnit>)>;
    std::function<Result<stream::MediaUnit>(const stream::FetchRequest&)> make;

    void fetch(stream::FetchRequest request, Done done) override {
        {
            std::lock_guard lock(mutex_);
            requests.push_back(request);
            requests.back().admit = nullptr;  // it holds what is claimed for the picture
            if (!make) waiting_.push_back(std::move(done));
        }
        if (make) done(make(request));
    }
    std::size_t request_count() const {
        std::lock_guard lock(mutex_);
        return requests.size();
    }
    /// Answers the oldest request that waits.
    void answer(Result<stream::MediaUnit> unit) {
        Done done;
        {
            std::lock_guard lock(mutex_);
            done = std::move(waiting_.front());
            waiting_.pop_front();
        }
        done(std::move(unit));
    }

    std::vector<stream::FetchRequest> requests;

private:
    mutable std::mutex mutex_;
    std::list<Done> waiting_;
};

}  // namespace camrig::http
