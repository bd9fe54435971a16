#include "core/stream/output.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include <spdlog/spdlog.h>

#include "core/base/clock.h"
#include "core/base/out_of_memory.h"
#include "core/fault/delivery.h"
#include "core/fault/sending.h"

namespace camrig::stream {
namespace {

/// How long a sink that is unavailable is left alone before it is opened again.
constexpr TimeNs reopen_after_ns = ns_per_s;

bool takes(const Reader& reader, TimeNs world_ns) {
    return !reader.options.rate || reader.options.rate->frames_until(world_ns) != reader.ticks_taken;
}

std::uint64_t taken_of(const Reader& reader, const MissedFrames& frames) {
    if (!reader.options.rate) return frames.count;
    const Rate& rate = *reader.options.rate;
    const std::int64_t ticks =
        rate.frames_until(frames.last_ns) - std::max(reader.ticks_taken, rate.frames_until(frames.first_ns) - 1);
    return std::min(frames.count, static_cast<std::uint64_t>(std::max<std::int64_t>(ticks, 0)));
}

/// With the reader's mutex held.
void drop_late(Reader& reader) {
    reader.stats->dropped.fetch_add(reader.late.size(), std::memory_order_relaxed);
    reader.late.clear();
}

}  // namespace

Output::Output(CameraStream camera, std::unique_ptr<Transcoder> transcoder, WorkerPool& pool, ReaderLog& log)
    : camera_(std::move(camera)), transcoder_(std::move(transcoder)), pool_(pool), log_(log) {}

void Output::note(ReaderEventKind kind, const Reader& reader, TimeNs world_ns) {
    log_.add({.kind = kind,
              .camera = camera_.name,
              .output = reader.options.kind,
              .peer = reader.options.peer,
              .world_ns = world_ns});
}

void Output::attach(std::shared_ptr<Reader> reader) {
    std::lock_guard lock(mutex_);
    readers_.push_back(std::move(reader));
}

bool Output::detach(const std::shared_ptr<Reader>& reader) {
    bool empty = false;
    {
        std::lock_guard lock(mutex_);
        std::erase(readers_, reader);
        empty = readers_.empty();
    }
    std::lock_guard lock(reader->mutex);
    drop_late(*reader);
    if (std::exchange(reader->state, Reader::State::closed) != Reader::State::closed) reader->sink->close();
    return empty;
}

void Output::end(Error why) {
    pool_.post_beyond_limit([self = shared_from_this(), why = std::move(why)] {
        std::vector<std::shared_ptr<Reader>> all;
        {
            std::lock_guard lock(self->mutex_);
            all.swap(self->readers_);
        }
        for (const auto& reader : all) self->end_reader(reader, why);
    });
}

void Output::end_reader(const std::shared_ptr<Reader>& reader, Error why) {
    {
        std::lock_guard lock(reader->mutex);
        drop_late(*reader);
        if (std::exchange(reader->state, Reader::State::closed) == Reader::State::closed) return;
        reader->sink->close();
    }
    if (reader->on_end) reader->on_end(std::move(why));
}

std::size_t Output::reader_count() const {
    std::lock_guard lock(mutex_);
    return readers_.size();
}

bool Output::wants(TimeNs world_ns) const {
    std::lock_guard lock(mutex_);
    return std::ranges::any_of(readers_, [&](const auto& reader) { return takes(*reader, world_ns); });
}

std::uint64_t Output::miss(const MissedFrames& frames, DropReason reason) {
    std::lock_guard lock(mutex_);
    std::uint64_t most = 0;
    for (const auto& reader : readers_) most = std::max(most, taken_of(*reader, frames));
    if (most == 0) return 0;
    (reason == DropReason::fault ? missed_by_fault_ : not_drawn_).fetch_add(most, std::memory_order_relaxed);
    if (reason == DropReason::fault)
        for (const auto& reader : readers_) reader->is_well = false;
    return most;
}

void Output::offer(const frame::FrameRef& frame, const std::shared_ptr<DeliveryLatch>& latch) {
    const TimeNs world_ns = frame->info().world_ns;
    Item item;
    {
        std::lock_guard lock(mutex_);
        for (const auto& reader : readers_) {
            if (!takes(*reader, world_ns)) continue;
            if (reader->options.rate) reader->ticks_taken = reader->options.rate->frames_until(world_ns);
            reader->stats->offered.fetch_add(1, std::memory_order_relaxed);
            item.takers.push_back(reader);
        }
    }
    if (item.takers.empty()) return;
    received_.fetch_add(1, std::memory_order_relaxed);
    item.frame = frame;
    item.latch = latch;
    if (latch) item.hold = latch->hold("encoding of camera " + camera_.name + " (" + describe(format()) + ")");
    if (const auto replaced = slot_.put(std::move(item))) {
        dropped_.fetch_add(1, std::memory_order_relaxed);
        for (const auto& reader : replaced->takers) reader->stats->dropped.fetch_add(1, std::memory_order_relaxed);
    }
}

void Output::post_run() {
    // One waits at most. Were it refused, the slot would never be emptied, nor its latch let go.
    pool_.post_beyond_limit([self = shared_from_this()] { self->run(); });
}

void Output::run() {
    auto item = slot_.take();
    if (!item) return;
    deliver(std::move(*item));
    post_run();  // one frame per turn: a busy output does not keep the others of the pool waiting
}

void Output::leave_out_failing(Item& item) {
    const frame::FrameInfo& info = item.frame->info();
    if (!info.faults) return;
    for (const auto& reader : item.takers) reader->is_well = false;
    std::erase_if(item.takers, [&](const std::shared_ptr<Reader>& reader) {
        const bool is_out = is_disconnected(*info.faults, reader->options.kind);
        if (!is_out && !is_stalled(*info.faults, reader->options.kind)) return false;
        reader->stats->dropped.fetch_add(1, std::memory_order_relaxed);
        reader->stats->fault.fetch_add(1, std::memory_order_relaxed);
        if (!is_out) {
            std::lock_guard lock(reader->mutex);
            reader->sink->hold_back();
            return true;
        }
        {
            std::lock_guard lock(mutex_);
            if (std::erase(readers_, reader) == 0) return true;
        }
        note(ReaderEventKind::thrown_out, *reader, info.world_ns);
        if (is_reset(*info.faults, reader->options.kind)) {
            std::lock_guard lock(reader->mutex);
            reader->sink->reset();
        }
        end_reader(reader, {ErrorKind::not_found, "camera " + camera_.name + " is disconnected (a fault)"});
        return true;
    });
}

MediaUnit Output::unit_for(const Reader& reader, const frame::FrameRef& frame, const MediaUnit& unit) {
    if (!unit.info.faults || !unit.bytes) return unit;
    MediaUnit own = unit;
    if (const auto size = fault::other_size(*unit.info.faults, reader.options.kind, unit.info.size)) {
        if (const auto other = transcoder_->of_size(*size))
            if (const auto small = (*other)->transcode(frame)) own.bytes = small->bytes;
    }
    auto damaged = fault::damaged_jpeg(*unit.info.faults, reader.options.kind, *own.bytes);
    if (damaged || own.bytes != unit.bytes) reader.stats->damaged.fetch_add(1, std::memory_order_relaxed);
    if (!damaged) return own;
    for (const fault::Harm& harm : damaged->harms) fault::note(*unit.info.faults, reader.options.kind, harm);
    own.bytes = std::make_shared<const std::vector<std::byte>>(std::move(damaged->bytes));
    return own;
}

void Output::deliver(Item item) {
    leave_out_failing(item);
    if (item.takers.empty()) {
        kept_back_.fetch_add(1, std::memory_order_relaxed);
        return;
    }
    auto unit = or_out_of_memory("encoding", [&] { return transcoder_->transcode(item.frame); });
    if (!unit) {
        failed_.fetch_add(1, std::memory_order_relaxed);
        for (const auto& reader : item.takers) {
            reader->stats->dropped.fetch_add(1, std::memory_order_relaxed);
            {
                std::lock_guard lock(mutex_);
                std::erase(readers_, reader);
            }
            end_reader(reader, unit.error());
        }
        return;
    }
    encoded_.fetch_add(1, std::memory_order_relaxed);
    unit->latch = item.latch;
    for (const auto& reader : item.takers) {
        Result<void> written;
        {
            std::lock_guard lock(reader->mutex);
            written = write_in_time(*reader, unit_for(*reader, item.frame, *unit));
        }
        if (written) continue;
        spdlog::info("camera {}: {} reader {} ends: {}", camera_.name, reader->options.kind, reader->options.peer,
                     written.error().message);
        {
            std::lock_guard lock(mutex_);
            if (std::erase(readers_, reader) == 0) continue;  // whoever detached it hears of it no more
        }
        if (reader->on_end) reader->on_end(written.error());
    }
}

Result<void> Output::write_in_time(Reader& reader, MediaUnit unit) {
    const fault::FrameFaults* const faults = unit.info.faults.get();
    const std::string& kind = reader.options.kind;
    // RTSP's line takes packets, behind the payloader.
    const bool has_line = unit.bytes && kind != to_string(fault::Output::rtsp);
    const auto rate = faults && has_line ? fault::line_rate(*faults, kind) : std::nullopt;
    if (!reader.line.takes(rate, unit.info.world_ns, unit.bytes ? unit.bytes->size() : 0)) {
        reader.stats->dropped.fetch_add(1, std::memory_order_relaxed);
        reader.stats->fault.fetch_add(1, std::memory_order_relaxed);
        fault::note(*faults, kind, fault::whole_loss(*rate->by, unit.bytes->size()));
        reader.sink->hold_back();
        return {};
    }
    const std::int64_t late = faults ? fault::frames_late(*faults, kind) : 0;
    if (late == 0 && reader.late.empty()) return write(reader, unit);
    const frame::FrameInfo now = unit.info;
    const auto latch = std::exchange(unit.latch, nullptr);  // a step does not wait for what comes with a later one
    reader.late.push_back(std::move(unit));
    bool is_written = false;
    while (!reader.late.empty()) {
        const frame::FrameInfo& first = reader.late.front().info;
        // By what fails now: those that wait come at once when the fault is over.
        const bool is_due = late == 0 || now.sequence - first.sequence >= fault::frames_late(*first.faults, kind) ||
                            std::ssize(reader.late) > fault::Late::max_frames;
        if (!is_due) break;
        MediaUnit next = std::move(reader.late.front());
        reader.late.pop_front();
        next.latch = latch;
        is_written = true;
        if (auto written = write(reader, next); !written) return written;
    }
    if (!is_written) reader.sink->hold_back();
    return {};
}

Result<void> Output::write(Reader& reader, const MediaUnit& unit) {
    using State = Reader::State;
    const auto drop = [&]() -> Result<void> {
        reader.stats->dropped.fetch_add(1, std::memory_order_relaxed);
        return {};
    };
    const auto wait_or_end = [&](const Error& why) -> Result<void> {
        std::ignore = drop();
        if (why.kind != ErrorKind::unavailable) return std::unexpected(why);
        if (reader.state != State::waiting) {
            spdlog::warn("camera {}: {} {}: {}; trying again each second", camera_.name, reader.options.kind,
                         reader.options.peer, why.message);
        }
        reader.state = State::waiting;
        reader.retry_at_ns = monotonic_now_ns() + reopen_after_ns;
        return {};
    };

    if (reader.state == State::closed) return drop();
    if (reader.state == State::waiting && monotonic_now_ns() < reader.retry_at_ns) return drop();
    if (reader.state != State::open) {
        if (const auto opened = reader.sink->open({unit.info.size, reader.stats}); !opened)
            return wait_or_end(opened.error());
        reader.state = State::open;
    }
    const auto written = or_out_of_memory("sending", [&] { return reader.sink->write(unit); });
    if (!written) {
        reader.sink->close();
        const auto ended = wait_or_end(written.error());
        if (!ended) reader.state = State::closed;
        return ended;
    }
    if (!unit.info.faults && !reader.is_well) {
        reader.is_well = true;
        note(ReaderEventKind::good, reader, unit.info.world_ns);
    }
    return {};
}

OutputReport Output::report() const {
    OutputReport report;
    report.format = describe(format());
    report.fault = missed_by_fault_.load();
    report.not_drawn = not_drawn_.load();
    report.received = received_.load();
    report.kept_back = kept_back_.load();
    report.due = report.received + report.fault + report.not_drawn;
    report.encoded = encoded_.load();
    report.dropped = dropped_.load();
    report.failed = failed_.load();
    std::lock_guard lock(mutex_);
    for (const auto& reader : readers_) {
        report.readers.push_back(reader->stats->report());
        std::ranges::move(reader->sink->readers(), std::back_inserter(report.readers));
    }
    return report;
}

}  // namespace camrig::stream
