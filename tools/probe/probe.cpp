#include "tools/probe/probe.h"

#include <atomic>
#include <mutex>
#include <thread>

#include "core/base/clock.h"
#include "tools/probe/first_burst.h"

namespace camrig::probe {
namespace {

constexpr TimeNs look_up_ns = 100 * ns_per_ms;  ///< how often a waiting reader looks whether it shall end

/// What the readers of one probe share.
class ProbeRun {
public:
    ProbeRun(const ProbeOptions& options, std::size_t count) : options_(options), unready_(count) {}

    /// The whole life of one source.
    void read(SourceLog& log) {
        auto source = open_source(log.source, options_.source);
        if (!source) return fail(log, source.error());
        log.kind = (*source)->kind();
        TimeNs last_ns = monotonic_now_ns();
        FirstBurst burst;
        bool ready = false;
        while (!is_over(log)) {
            auto picture = (*source)->next(monotonic_now_ns() + look_up_ns);
            if (!picture) return fail(log, picture.error());
            if (!*picture) {
                if (monotonic_now_ns() - last_ns > options_.source.timeout_ns) return fail(log, silent(log));
                continue;
            }
            last_ns = (*picture)->arrival_ns;
            if (!ready && (ready = burst.is_over(last_ns, (*picture)->stamp_ns))) arrived();
            if (start_ns_ == 0 || last_ns < start_ns_) continue;
            keep(log, **source, **picture);
        }
    }

    std::optional<Error> failure() {
        std::lock_guard lock(mutex_);
        return failure_;
    }

private:
    bool is_over(const SourceLog& log) const {
        if (stop_ || std::ssize(log.pictures) >= options_.pictures) return true;
        return start_ns_ != 0 && monotonic_now_ns() - start_ns_ > options_.duration_ns;
    }

    Error silent(const SourceLog& log) const {
        const std::string after =
            log.pictures.empty() ? "no picture" : "no picture after " + std::to_string(log.pictures.size());
        return {ErrorKind::unavailable, after + " for " + std::to_string(options_.source.timeout_ns / ns_per_s) +
                                            " s (--timeout to wait longer; a paused world sends none)"};
    }

    /// Everybody begins when the last source delivers, and what it had piled up is taken.
    void arrived() {
        if (--unready_ == 0) start_ns_ = monotonic_now_ns();
    }

    static void keep(SourceLog& log, const Source& source, const ProbedPicture& picture) {
        if (log.format.empty()) log.format = source.format();
        log.size = picture.size;
        // The first sender report of an RTSP stream changes the clock of its stamps.
        if (std::exchange(log.stamps_are_monotonic, source.stamps_are_monotonic()) != log.stamps_are_monotonic)
            for (PictureRecord& earlier : log.pictures) earlier.stamp_ns.reset();
        PictureRecord record{picture.arrival_ns, picture.stamp_ns, picture.sequence, std::nullopt, picture.damaged};
        if (!picture.gray.empty())
            record.strip = read_code_strip(picture.gray, picture.size, frame::PixelFormat::gray8);
        log.pictures.push_back(record);
    }

    void fail(const SourceLog& log, Error why) {
        std::lock_guard lock(mutex_);
        if (!failure_) failure_ = at(log.source, std::move(why)).error();
        stop_ = true;
    }

    const ProbeOptions& options_;
    std::atomic<std::size_t> unready_;
    std::atomic<TimeNs> start_ns_{0};  ///< 0: not all are ready
    std::atomic<bool> stop_{false};
    std::mutex mutex_;
    std::optional<Error> failure_;
};

}  // namespace

Result<ProbeReport> run_probe(const std::vector<std::string>& sources, const ProbeOptions& options) {
    std::vector<SourceLog> logs(sources.size());
    ProbeRun run(options, sources.size());
    {
        std::vector<std::jthread> readers;
        for (std::size_t i = 0; i < sources.size(); ++i) {
            logs[i].source = sources[i];
            readers.emplace_back([&run, &log = logs[i]] { run.read(log); });
        }
    }
    if (auto failure = run.failure()) return std::unexpected(std::move(*failure));
    return measure(logs);
}

}  // namespace camrig::probe
