#include "rtsp_out/http/metrics.h"

#include <charconv>
#include <initializer_list>
#include <string_view>
#include <utility>

namespace camrig::http {
namespace {

using Labels = std::initializer_list<std::pair<std::string_view, std::string_view>>;

class Writer {
public:
    /// HELP and TYPE come once, before a metric's samples, which stay together (the format demands it).
    void metric(std::string_view name, std::string_view type, std::string_view help) {
        name_ = name;
        out_.append("# HELP ").append(name).append(" ").append(help).append("\n");
        out_.append("# TYPE ").append(name).append(" ").append(type).append("\n");
    }
    void sample(Labels labels, std::uint64_t value, std::string_view suffix = {}) {
        line(labels, suffix, std::to_string(value));
    }
    void sample(Labels labels, double value, std::string_view suffix = {}) {
        char buffer[32];
        const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
        line(labels, suffix, {buffer, static_cast<std::size_t>(end - buffer)});
    }
    std::string take() && { return std::move(out_); }

private:
    void line(Labels labels, std::string_view suffix, std::string_view value) {
        out_.append(name_).append(suffix);
        char separator = '{';
        for (const auto& [name, text] : labels) {
            out_ += separator;
            out_.append(name).append("=\"");
            escape(text);
            out_ += '"';
            separator = ',';
        }
        if (labels.size() > 0) out_ += '}';
        out_.append(" ").append(value).append("\n");
    }
    void escape(std::string_view text) {
        for (const char c : text) {
            if (c == '\n') {
                out_ += "\\n";
                continue;
            }
            if (c == '\\' || c == '"') out_ += '\\';
            out_ += c;
        }
    }

    std::string out_;
    std::string_view name_;
};

double seconds(TimeNs ns) {
    return static_cast<double>(ns) / 1e9;
}

void write_cameras(Writer& out, const stream::RigReport& report) {
    using Field = std::uint64_t stream::CameraReport::*;
    const auto each = [&](std::string_view name, std::string_view help, Field field) {
        out.metric(name, "counter", help);
        for (const auto& camera : report.cameras) out.sample({{"camera", camera.name}}, camera.*field);
    };
    each("camrig_camera_frames_due_total", "Frames that fell due while somebody watched.", &stream::CameraReport::due);
    each("camrig_camera_frames_rendered_total", "Frames made.", &stream::CameraReport::rendered);
    out.metric("camrig_camera_frames_dropped_total", "counter", "Frames due that were not made.");
    for (const auto& camera : report.cameras)
        for (std::size_t i = 0; i < stream::drop_reason_names.size(); ++i)
            out.sample({{"camera", camera.name}, {"reason", std::string(stream::drop_reason_names[i])}},
                       camera.dropped_for[i]);
    each("camrig_camera_frames_idle_total", "Frames that nobody watched and that were not made.",
         &stream::CameraReport::idle);
}

void write_outputs(Writer& out, const stream::RigReport& report) {
    using Field = std::uint64_t stream::OutputReport::*;
    const auto each = [&](std::string_view name, std::string_view help, Field field) {
        out.metric(name, "counter", help);
        for (const auto& camera : report.cameras)
            for (const auto& output : camera.outputs)
                out.sample({{"camera", camera.name}, {"format", output.format}}, output.*field);
    };
    each("camrig_output_frames_received_total", "Frames offered to a conversion or encoding.",
         &stream::OutputReport::received);
    each("camrig_output_frames_encoded_total", "Frames converted or encoded.", &stream::OutputReport::encoded);
    each("camrig_output_frames_dropped_total", "Frames replaced by newer ones before encoding.",
         &stream::OutputReport::dropped);
    each("camrig_output_frames_failed_total", "Frames that could not be encoded.", &stream::OutputReport::failed);
}

void write_readers(Writer& out, const stream::RigReport& report) {
    const auto each = [&](std::string_view name, std::string_view type, std::string_view help, auto value_of) {
        out.metric(name, type, help);
        for (const auto& camera : report.cameras)
            for (const auto& output : camera.outputs)
                for (const auto& reader : output.readers)
                    out.sample({{"camera", camera.name},
                                {"format", output.format},
                                {"kind", reader.kind},
                                {"peer", reader.peer}},
                               value_of(reader));
    };
    each("camrig_reader_frames_offered_total", "counter", "Frames meant for a reader.",
         [](const stream::ReaderReport& reader) { return reader.offered; });
    each("camrig_reader_frames_delivered_total", "counter", "Frames handed to a reader.",
         [](const stream::ReaderReport& reader) { return reader.delivered; });
    each("camrig_reader_frames_dropped_total", "counter", "Frames a reader was too slow for.",
         [](const stream::ReaderReport& reader) { return reader.dropped; });
    each("camrig_reader_bytes_total", "counter", "Bytes handed to a reader.",
         [](const stream::ReaderReport& reader) { return reader.bytes; });
    each("camrig_reader_latency_seconds", "gauge", "Age of the newest frame when it was handed over.",
         [](const stream::ReaderReport& reader) { return reader.latency_ms / 1e3; });
}

void write_stages(Writer& out, const stream::RigReport& report) {
    out.metric("camrig_stage_duration_seconds", "summary", "Time a stage of the pipeline takes.");
    for (const auto& stage : report.stages) {
        const auto& summary = stage.summary;
        out.sample({{"stage", stage.name}, {"quantile", "0.5"}}, summary.p50_ms / 1e3);
        out.sample({{"stage", stage.name}, {"quantile", "0.99"}}, summary.p99_ms / 1e3);
        out.sample({{"stage", stage.name}, {"quantile", "0.999"}}, summary.p999_ms / 1e3);
        out.sample({{"stage", stage.name}}, summary.mean_ms * static_cast<double>(summary.count) / 1e3, "_sum");
        out.sample({{"stage", stage.name}}, summary.count, "_count");
    }
    out.metric("camrig_stage_duration_max_seconds", "gauge", "Longest time a stage took.");
    for (const auto& stage : report.stages) out.sample({{"stage", stage.name}}, stage.summary.max_ms / 1e3);
}

void write_renderer(Writer& out, const stream::RigReport& report) {
    for (const auto& counter : report.renderer) {
        const std::string name = "camrig_renderer_" + std::string(counter.name) + (counter.total ? "_total" : "");
        out.metric(name, counter.total ? "counter" : "gauge", counter.help);
        out.sample({}, counter.value);
    }
}

void write_http(Writer& out, const HttpCounts& http) {
    const auto one = [&](std::string_view name, std::string_view type, std::string_view help, std::uint64_t value) {
        out.metric(name, type, help);
        out.sample({}, value);
    };
    one("camrig_http_connections", "gauge", "HTTP connections open.", http.connections.open);
    one("camrig_http_connections_total", "counter", "HTTP connections accepted.", http.connections.total);
    one("camrig_http_connections_refused_total", "counter", "HTTP connections over the limit.",
        http.connections.refused);
    one("camrig_http_connections_displaced_total", "counter", "HTTP connections closed while idle for new ones.",
        http.connections.displaced);
    one("camrig_http_wrong_tokens_total", "counter", "HTTP requests with a wrong token.",
        http.connections.wrong_tokens);
    one("camrig_http_requests_total", "counter", "HTTP requests answered.", http.requests);
    one("camrig_http_errors_total", "counter", "HTTP answers with status 400 and above.", http.errors);
    one("camrig_http_streams", "gauge", "MJPEG streams open.", http.streams_open);
    one("camrig_http_first_parts_total", "counter", "Pictures fetched to open a stream.", http.first_parts);
    one("camrig_http_repeated_parts_total", "counter", "Pictures repeated because nothing new came.",
        http.repeated_parts);
    one("camrig_http_streams_stalled_total", "counter", "Streams closed because the client took nothing.",
        http.stalled);
}

}  // namespace

std::string to_prometheus(const stream::RigReport& report, const HttpCounts& http) {
    Writer out;
    out.metric("camrig_world_time_seconds", "gauge", "The world's own time.");
    out.sample({}, seconds(report.world_ns));
    out.metric("camrig_instants_total", "counter", "Instants at which something was due.");
    out.sample({}, report.instants);
    out.metric("camrig_instants_dropped_total", "counter", "Instants of which pictures were dropped.");
    out.sample({}, report.dropped_instants);
    write_cameras(out, report);
    write_outputs(out, report);
    write_readers(out, report);
    write_stages(out, report);
    write_renderer(out, report);
    write_http(out, http);
    return std::move(out).take();
}

}  // namespace camrig::http
