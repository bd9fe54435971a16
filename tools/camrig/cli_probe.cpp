#include <cstdio>
#include <memory>
#include <ostream>

#include <CLI/CLI.hpp>

#include "core/base/token.h"
#include "tools/camrig/cli_commands.h"
#include "tools/probe/probe.h"

namespace camrig::cli {
namespace {

using nlohmann::json;
using ProbeRows = std::vector<std::vector<std::string>>;

struct ProbeArguments {
    std::vector<std::string> sources;
    double seconds = 5;
    double timeout_s = 5;
    probe::ProbeOptions options;
};

double ms_of(TimeNs ns) {
    return static_cast<double>(ns) / ns_per_ms;
}

json spread_json(const std::optional<probe::Spread>& spread) {
    if (!spread) return nullptr;
    return {{"p50", ms_of(spread->p50_ns)}, {"p99", ms_of(spread->p99_ns)}, {"max", ms_of(spread->max_ns)}};
}

json report_json(const probe::ProbeReport& report) {
    json sources = json::array(), skews = json::array();
    for (const probe::SourceReport& one : report.sources) {
        sources.push_back({{"source", one.source},
                           {"kind", one.kind},
                           {"format", one.format},
                           {"size", {one.size.width, one.size.height}},
                           {"pictures", one.pictures},
                           {"seconds", one.seconds},
                           {"rate", one.rate_hz},
                           {"drops", one.drops},
                           {"repeats", one.repeats},
                           {"out_of_order", one.out_of_order},
                           {"torn", one.torn},
                           {"strips", one.strips},
                           {"arrival_jitter_ms", spread_json(one.arrival_jitter)},
                           {"stamp_jitter_ms", spread_json(one.stamp_jitter)},
                           {"latency_ms", spread_json(one.latency)},
                           {"latency_by", one.latency ? json(one.latency_by) : json(nullptr)}});
    }
    for (const probe::SkewReport& one : report.skews) {
        skews.push_back({{"source", one.source},
                         {"reference", one.reference},
                         {"pictures", one.pictures},
                         {"common", one.common},
                         {"world_ms", spread_json(one.world)},
                         {"stamp_max_ns", one.stamp_max_ns ? json(*one.stamp_max_ns) : json(nullptr)},
                         {"arrival_ms", spread_json(one.arrival)}});
    }
    return {{"sources", std::move(sources)}, {"skew", std::move(skews)}};
}

std::string decimals(double value, int digits) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

/// "p50 p99 max" in milliseconds, or "-".
std::string spread_words(const std::optional<probe::Spread>& spread) {
    if (!spread) return "-";
    return decimals(ms_of(spread->p50_ns), 2) + " " + decimals(ms_of(spread->p99_ns), 2) + " " +
           decimals(ms_of(spread->max_ns), 2);
}

std::string report_words(const probe::ProbeReport& report) {
    ProbeRows pictures{{"SOURCE", "FORMAT", "PICTURES", "RATE", "DROPS", "REPEATS", "OUT OF ORDER", "TORN", "STRIPS"}};
    ProbeRows times{{"MS: P50 P99 MAX", "ARRIVAL JITTER", "STAMP JITTER", "LATENCY"}};
    for (const probe::SourceReport& one : report.sources) {
        pictures.push_back({one.source, one.format + " " + one.size.to_string(), std::to_string(one.pictures),
                            decimals(one.rate_hz, 2), std::to_string(one.drops), std::to_string(one.repeats),
                            std::to_string(one.out_of_order), std::to_string(one.torn), std::to_string(one.strips)});
        times.push_back({one.source, spread_words(one.arrival_jitter), spread_words(one.stamp_jitter),
                         spread_words(one.latency) + (one.latency ? " by " + one.latency_by : "")});
    }
    std::string text = table(pictures, 2) + "\n" + table(times);
    if (report.skews.empty()) return text;
    ProbeRows skews{{"SKEW", "AGAINST", "PICTURES", "SAME INSTANT", "WORLD MS P50 P99 MAX", "STAMPS NS", "ARRIVAL MS"}};
    for (const probe::SkewReport& one : report.skews) {
        skews.push_back({one.source, one.reference, std::to_string(one.pictures), std::to_string(one.common),
                         spread_words(one.world), one.stamp_max_ns ? std::to_string(*one.stamp_max_ns) : "-",
                         spread_words(one.arrival)});
    }
    return text + "\n" + table(skews, 2);
}

int probe(const CliContext& context, ProbeArguments& arguments) {
    probe::ProbeOptions& options = arguments.options;
    options.duration_ns = static_cast<TimeNs>(arguments.seconds * ns_per_s);
    options.source.timeout_ns = static_cast<TimeNs>(arguments.timeout_s * ns_per_s);
    if (!context.token_file.empty()) {
        auto token = read_token_file(context.token_file);
        if (!token) return context.fail(token.error());
        options.source.token = std::move(*token);
    }
    const auto report = run_probe(arguments.sources, options);
    return report ? context.print(report_json(*report), report_words(*report)) : context.fail(report.error());
}

}  // namespace

void add_probe_command(CLI::App& app, CliContext& context) {
    constexpr std::size_t max_sources = 64;
    constexpr double max_seconds = 3600;
    auto arguments = std::make_shared<ProbeArguments>();
    probe::ProbeOptions& options = arguments->options;
    CLI::App* command =
        app.add_subcommand("probe", "opens devices and URLs as an ordinary client; prints rate, drops, skew, latency");
    command->add_option("SOURCE", arguments->sources, "/dev/videoN, http://... (MJPEG) or rtsp://...")
        ->required()
        ->expected(1, max_sources);
    auto* seconds = command->add_option("--seconds", arguments->seconds, "how long to measure; default 5")
                        ->check(CLI::Range(0.1, max_seconds));
    auto* frames = command->add_option("--frames", options.pictures, "ends after so many pictures of each source")
                       ->check(CLI::Range(std::int64_t{1}, probe::ProbeOptions::max_pictures));
    command->add_option("--timeout", arguments->timeout_s, "seconds to wait for a source; default 5")
        ->check(CLI::Range(0.1, max_seconds));
    command->add_option("--format", options.source.device_format, "fourcc to ask of devices, e.g. MJPG");
    command->add_flag("--rtsp-udp", options.source.rtsp_over_udp, "RTP over UDP instead of within the RTSP connection");
    command->callback([arguments, seconds, frames, &context] {
        if (frames->count() > 0 && seconds->count() == 0) arguments->seconds = max_seconds;
        context.action = [arguments, &context] { return probe(context, *arguments); };
    });
}

}  // namespace camrig::cli
