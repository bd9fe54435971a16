#include "tools/view/arrangement.h"

#include <algorithm>
#include <span>
#include <vector>

#include "core/base/write_file.h"

namespace camrig::view {
namespace {

using nlohmann::json;

constexpr std::size_t max_name = 24;

}  // namespace

json arrangement_of(const json& camera_list, const std::string& without) {
    json cameras = json::array();
    for (json camera : camera_list.value("cameras", json::array())) {
        if (camera.value("name", "") == without) continue;
        for (const char* key : {"id", "sequence", "readers", "applied_ns", "arrives_ns", "world_pose",
                                "shown_intrinsics", "vfov_deg", "hfov_deg"})
            camera.erase(key);
        // The angles say it to people, and exactly.
        if (auto pose = camera.find("pose"); pose != camera.end()) pose->erase("orientation");
        cameras.push_back(std::move(camera));
    }
    return {{"cameras", std::move(cameras)}};
}

Result<void> write_arrangement(const std::filesystem::path& file, const json& arrangement) {
    const std::string text = arrangement.dump(2) + "\n";
    return write_atomically(file, std::as_bytes(std::span(text)));
}

std::string free_name(const std::string& like, const std::vector<std::string>& taken) {
    std::string stem = like;
    const std::size_t underscore = like.rfind('_');
    if (underscore != std::string::npos && underscore + 1 < like.size() &&
        std::all_of(like.begin() + static_cast<std::ptrdiff_t>(underscore) + 1, like.end(),
                    [](char c) { return c >= '0' && c <= '9'; }))
        stem.resize(underscore);
    for (int number = 2;; ++number) {  // ends: there are fewer cameras than numbers
        const std::string ending = "_" + std::to_string(number);
        std::string name = stem.substr(0, max_name - ending.size()) + ending;
        if (std::ranges::find(taken, name) == taken.end()) return name;
    }
}

}  // namespace camrig::view
