#include "core/bake/checkpoint.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <span>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "core/base/write_file.h"

namespace camrig::bake {
namespace {

/// The first line of the file; then the light as it lies in memory, layer after layer.
std::string first_line(const std::string& title, std::size_t layers, std::size_t texels, int passes) {
    return fmt::format("camrig bake 1 {} {}x{} passes {}\n", title, layers, texels, passes);
}

}  // namespace

int Checkpoint::resume(std::vector<std::vector<glm::vec3>>& light) const {
    constexpr int most_passes = 1000;
    std::ifstream in(file_, std::ios::binary);
    std::string line;
    if (light.empty() || !std::getline(in, line)) return 0;
    line += '\n';
    int passes = 0;
    while (passes < most_passes && line != first_line(title_, light.size(), light[0].size(), passes)) ++passes;
    if (passes == 0 || passes == most_passes) return 0;
    auto read = light;
    for (auto& layer : read) {
        const auto bytes = std::as_writable_bytes(std::span(layer));
        if (!in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()))) return 0;
        const auto is_light = [](const glm::vec3& value) {
            return std::isfinite(value.r) && std::isfinite(value.g) && std::isfinite(value.b);
        };
        if (!std::ranges::all_of(layer, is_light)) return 0;
    }
    light = std::move(read);
    return passes;
}

void Checkpoint::keep(int passes, const std::vector<std::vector<glm::vec3>>& light) {
    if (file_.empty() || has_failed_ || light.empty()) return;
    const std::string line = first_line(title_, light.size(), light[0].size(), passes);
    std::vector<std::byte> bytes(std::as_bytes(std::span(line)).begin(), std::as_bytes(std::span(line)).end());
    for (const auto& layer : light) {
        const auto of_layer = std::as_bytes(std::span(layer));
        bytes.insert(bytes.end(), of_layer.begin(), of_layer.end());
    }
    const auto written = write_atomically(file_, bytes);
    if (written) return;
    has_failed_ = true;
    spdlog::warn("bake: {}; it could not go on from here if it was ended", written.error().message);
}

}  // namespace camrig::bake
