#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/image_size.h"
#include "core/base/time.h"
#include "core/frame/code_strip.h"

namespace camrig::probe {

/// What is kept of each picture of a source.
struct PictureRecord {
    TimeNs arrival_ns = 0;
    std::optional<TimeNs> stamp_ns = {};
    std::optional<std::int64_t> sequence;
    std::optional<frame::CodeStrip> strip;
    bool damaged = false;
};

/// All pictures of one source, in the order they came.
struct SourceLog {
    std::string source;  ///< as the user named it
    std::string kind, format;
    ImageSize size;
    bool stamps_are_monotonic = false;
    std::vector<PictureRecord> pictures = {};
};

/// Of a set of durations. Percentiles by nearest rank.
struct Spread {
    TimeNs p50_ns = 0, p99_ns = 0, max_ns = 0;
    static std::optional<Spread> of(std::vector<TimeNs> durations);
};

struct SourceReport {
    std::string source, kind, format;
    ImageSize size;
    std::int64_t pictures = 0;
    double seconds = 0;  ///< from the first picture to the last
    double rate_hz = 0;
    std::int64_t drops = 0;         ///< missing numbers in the source's own count, else in the strip's
    std::int64_t repeats = 0;       ///< pictures that show the one before once more
    std::int64_t out_of_order = 0;  ///< pictures that are older than the one before
    std::int64_t torn = 0;          ///< damaged, or with a strip that cannot be read though others of this source could
    std::int64_t strips = 0;        ///< pictures with a readable strip
    std::optional<Spread> arrival_jitter = {};  ///< |interval - median interval| of arrivals
    std::optional<Spread> stamp_jitter = {};    ///< of stamps
    std::optional<Spread> latency = {};         ///< arrival - instant shown
    std::string latency_by;                     ///< "stamp", or "strip" (world time, by another source's stamps)
};

/// Two sources against each other, by their strips.
struct SkewReport {
    std::string source, reference;
    std::int64_t pictures = 0;  ///< of `source`, while the reference ran
    std::int64_t common = 0;    ///< of these: shown by the reference too, at exactly this world time
    std::optional<Spread> world =
        {};  ///< from each picture to the nearest of the reference in world time; 0: synchronous
    std::optional<TimeNs> stamp_max_ns = {};  ///< largest difference of the stamps of one world time
    std::optional<Spread> arrival = {};       ///< differences of arrival of one world time
};

struct ProbeReport {
    std::vector<SourceReport> sources;
    std::vector<SkewReport> skews;  ///< of each source with strips to the first that has some
};

/// Pure arithmetic; the logs are not changed.
ProbeReport measure(const std::vector<SourceLog>& logs);

}  // namespace camrig::probe
