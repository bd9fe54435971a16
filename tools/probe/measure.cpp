#include "tools/probe/measure.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

namespace camrig::probe {
namespace {

TimeNs rank(const std::vector<TimeNs>& sorted, std::size_t percent) {
    return sorted[(sorted.size() * percent + 99) / 100 - 1];
}

/// How far the distances between neighbours are from the usual one.
std::optional<Spread> jitter_of(const std::vector<TimeNs>& times) {
    if (times.size() < 3) return std::nullopt;
    std::vector<TimeNs> intervals;
    for (std::size_t i = 1; i < times.size(); ++i) intervals.push_back(times[i] - times[i - 1]);
    std::vector<TimeNs> sorted = intervals;
    std::ranges::sort(sorted);
    const TimeNs usual = rank(sorted, 50);
    for (TimeNs& interval : intervals) interval = std::abs(interval - usual);
    return Spread::of(std::move(intervals));
}

/// The number that counts this source's pictures: its own if it has one, else the strip's.
std::optional<std::int64_t> number_of(const PictureRecord& picture) {
    if (picture.sequence) return picture.sequence;
    if (picture.strip) return picture.strip->sequence;
    return std::nullopt;
}

void count_order(const SourceLog& log, SourceReport& report) {
    const PictureRecord* before = nullptr;
    for (const PictureRecord& picture : log.pictures) {
        if (picture.strip) ++report.strips;
        if (before) {
            const auto number = number_of(picture), last = number_of(*before);
            if (number && last && *number > *last + 1) report.drops += *number - *last - 1;
            // What a picture shows is told by its strip; a device numbers a repeated picture anew.
            const bool by_strip = picture.strip && before->strip;
            const auto shown = by_strip ? std::optional<std::int64_t>(picture.strip->sequence) : number;
            const auto shown_before = by_strip ? std::optional<std::int64_t>(before->strip->sequence) : last;
            if (shown && shown_before && *shown == *shown_before) ++report.repeats;
            if (shown && shown_before && *shown < *shown_before) ++report.out_of_order;
        }
        before = &picture;
    }
    for (const PictureRecord& picture : log.pictures)
        if (picture.damaged || (report.strips > 0 && !picture.strip)) ++report.torn;
}

/// world_ns + this = CLOCK_MONOTONIC, as a source with stamps and strips shows it; only while the world runs with it.
std::optional<TimeNs> monotonic_from_world(const std::vector<SourceLog>& logs) {
    for (const SourceLog& log : logs) {
        if (!log.stamps_are_monotonic) continue;
        std::vector<TimeNs> offsets;
        for (const PictureRecord& picture : log.pictures)
            if (picture.stamp_ns && picture.strip) offsets.push_back(*picture.stamp_ns - picture.strip->world_ns);
        if (offsets.empty()) continue;
        const auto [least, most] = std::ranges::minmax(offsets);
        if (most - least < ns_per_ms) return least;
    }
    return std::nullopt;
}

void find_latency(const SourceLog& log, std::optional<TimeNs> offset_ns, SourceReport& report) {
    std::vector<TimeNs> latencies;
    for (const PictureRecord& picture : log.pictures) {
        if (log.stamps_are_monotonic && picture.stamp_ns) latencies.push_back(picture.arrival_ns - *picture.stamp_ns);
        if (!log.stamps_are_monotonic && picture.strip && offset_ns)
            latencies.push_back(picture.arrival_ns - picture.strip->world_ns - *offset_ns);
    }
    report.latency = Spread::of(std::move(latencies));
    if (report.latency) report.latency_by = log.stamps_are_monotonic ? "stamp" : "strip";
}

SourceReport report_of(const SourceLog& log, std::optional<TimeNs> offset_ns) {
    SourceReport report;
    report.source = log.source;
    report.kind = log.kind;
    report.format = log.format;
    report.size = log.size;
    report.pictures = std::ssize(log.pictures);
    std::vector<TimeNs> arrivals, stamps;
    for (const PictureRecord& picture : log.pictures) {
        arrivals.push_back(picture.arrival_ns);
        if (picture.stamp_ns) stamps.push_back(*picture.stamp_ns);
    }
    if (arrivals.size() > 1) {
        report.seconds = static_cast<double>(arrivals.back() - arrivals.front()) / ns_per_s;
        if (report.seconds > 0) report.rate_hz = static_cast<double>(arrivals.size() - 1) / report.seconds;
    }
    report.arrival_jitter = jitter_of(arrivals);
    report.stamp_jitter = jitter_of(stamps);
    count_order(log, report);
    find_latency(log, offset_ns, report);
    return report;
}

using ByWorldTime = std::map<TimeNs, const PictureRecord*>;

/// The first picture of each instant.
ByWorldTime by_world_time(const SourceLog& log) {
    ByWorldTime pictures;
    for (const PictureRecord& picture : log.pictures)
        if (picture.strip) pictures.emplace(picture.strip->world_ns, &picture);
    return pictures;
}

SkewReport skew_of(const SourceLog& log, const SourceLog& reference_log) {
    SkewReport report{.source = log.source, .reference = reference_log.source};
    const ByWorldTime pictures = by_world_time(log), reference = by_world_time(reference_log);
    std::vector<TimeNs> world, arrival;
    for (const auto& [world_ns, picture] : pictures) {
        const auto after = reference.lower_bound(world_ns);
        // Only while both ran.
        if (after == reference.end() || (after == reference.begin() && after->first != world_ns)) continue;
        ++report.pictures;
        if (after->first != world_ns) {
            world.push_back(std::min(after->first - world_ns, world_ns - std::prev(after)->first));
            continue;
        }
        ++report.common;
        world.push_back(0);
        arrival.push_back(std::abs(picture->arrival_ns - after->second->arrival_ns));
        if (log.stamps_are_monotonic && reference_log.stamps_are_monotonic && picture->stamp_ns &&
            after->second->stamp_ns) {
            const TimeNs difference = std::abs(*picture->stamp_ns - *after->second->stamp_ns);
            report.stamp_max_ns = std::max(report.stamp_max_ns.value_or(0), difference);
        }
    }
    report.world = Spread::of(std::move(world));
    report.arrival = Spread::of(std::move(arrival));
    return report;
}

}  // namespace

std::optional<Spread> Spread::of(std::vector<TimeNs> durations) {
    if (durations.empty()) return std::nullopt;
    std::ranges::sort(durations);
    return Spread{rank(durations, 50), rank(durations, 99), durations.back()};
}

ProbeReport measure(const std::vector<SourceLog>& logs) {
    ProbeReport report;
    const auto offset_ns = monotonic_from_world(logs);
    const SourceLog* reference = nullptr;
    for (const SourceLog& log : logs) {
        report.sources.push_back(report_of(log, offset_ns));
        if (report.sources.back().strips == 0) continue;
        if (reference)
            report.skews.push_back(skew_of(log, *reference));
        else
            reference = &log;
    }
    return report;
}

}  // namespace camrig::probe
