#include "rtsp_out/http/metrics.h"

#include <map>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

namespace camrig::http {
namespace {

stream::RigReport report() {
    stream::RigReport rig;
    rig.world_ns = 1'500'000'000;
    rig.instants = 3;
    for (const char* name : {"lobby", "hall"}) {
        stream::CameraReport camera;
        camera.name = name;
        camera.due = 7;
        stream::OutputReport output;
        output.format = "jpeg \"q90\"\\\n";
        output.readers.push_back({"mjpeg", "127.0.0.1:5", 9, 8, 1, 1000, 2.5});
        camera.outputs.push_back(output);
        rig.cameras.push_back(camera);
    }
    rig.stages.push_back({"encode", {4, 2.0, 1.0, 5.0, 5.5, 6.0}});
    rig.renderer = {{"static_layers", false, 2, "Kept."}, {"draws", true, 40, "Draw calls."}};
    return rig;
}

TEST(Metrics, LabelsAreEscaped) {
    const std::string text = to_prometheus(report(), {});
    EXPECT_NE(
        text.find(
            "camrig_reader_frames_dropped_total{camera=\"lobby\",format=\"jpeg \\\"q90\\\"\\\\\\n\",kind=\"mjpeg\","
            "peer=\"127.0.0.1:5\"} 1\n"),
        std::string::npos)
        << text;
}

TEST(Metrics, ValuesComeThrough) {
    const std::string text = to_prometheus(report(), {});
    EXPECT_NE(text.find("\ncamrig_camera_frames_due_total{camera=\"hall\"} 7\n"), std::string::npos);
    EXPECT_NE(text.find("\ncamrig_world_time_seconds 1.5\n"), std::string::npos);
    EXPECT_NE(text.find("\ncamrig_stage_duration_seconds{stage=\"encode\",quantile=\"0.99\"} 0.005\n"),
              std::string::npos);
    EXPECT_NE(text.find("\ncamrig_stage_duration_seconds{stage=\"encode\",quantile=\"0.999\"} 0.0055\n"),
              std::string::npos);
    EXPECT_NE(text.find("\n# TYPE camrig_renderer_static_layers gauge\ncamrig_renderer_static_layers 2\n"),
              std::string::npos);
    EXPECT_NE(text.find("\n# TYPE camrig_renderer_draws_total counter\ncamrig_renderer_draws_total 40\n"),
              std::string::npos);
    EXPECT_NE(text.find("\ncamrig_stage_duration_seconds_sum{stage=\"encode\"} 0.008\n"), std::string::npos);
    EXPECT_NE(text.find("\ncamrig_stage_duration_seconds_count{stage=\"encode\"} 4\n"), std::string::npos);
}

// The text format: each metric has one HELP and one TYPE line, then all its samples together; no series twice.
TEST(Metrics, FollowsTheTextFormat) {
    std::istringstream lines(to_prometheus(report(), {}));
    std::string line, current;
    std::set<std::string> declared, series;
    while (std::getline(lines, line)) {
        if (line.starts_with("# HELP ")) {
            current = line.substr(7, line.find(' ', 7) - 7);
            EXPECT_TRUE(declared.insert(current).second) << line;
            ASSERT_TRUE(std::getline(lines, line));
            EXPECT_TRUE(line.starts_with("# TYPE " + current + " ")) << line;
            continue;
        }
        EXPECT_TRUE(line.starts_with(current)) << line;
        const std::size_t value = line.rfind(' ');
        ASSERT_NE(value, std::string::npos);
        EXPECT_TRUE(series.insert(line.substr(0, value)).second) << line;
        EXPECT_NO_THROW(static_cast<void>(std::stod(line.substr(value + 1)))) << line;
    }
    EXPECT_GT(series.size(), 30U);
}

}  // namespace
}  // namespace camrig::http
