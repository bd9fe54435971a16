#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "tools/probe/measure.h"
#include "tools/probe/source.h"

namespace camrig::probe {

struct ProbeOptions {
    static constexpr std::int64_t max_pictures = 1'000'000;  ///< of each source
    TimeNs duration_ns = 5 * ns_per_s;
    std::int64_t pictures = max_pictures;  ///< ends when every source has had so many
    SourceOptions source;
};

/// Opens all sources, each in a thread of its own, and reads them together from the moment the last one delivers. The
/// first failure ends it all. The first picture of a source is not measured: it may be an old one that was kept.
/// Takes the duration and at most twice the sources' timeout.
Result<ProbeReport> run_probe(const std::vector<std::string>& sources, const ProbeOptions& options);

}  // namespace camrig::probe
