#include "core/stream/camera_outputs.h"

#include <algorithm>

#include "core/base/output_family.h"

namespace camrig::stream {

CameraOutputs::Change CameraOutputs::update(const CameraStream& camera, bool is_there) {
    std::vector<OutputSpec> now;
    for (const OutputSpec& output : camera.outputs)
        if (is_there && output.kind == kind_) now.push_back(output);
    const std::vector<OutputSpec> before = std::exchange(outputs_[camera.name], now);
    if (now.empty()) outputs_.erase(camera.name);

    const auto find = [](const std::vector<OutputSpec>& among, const OutputSpec& output) {
        return std::ranges::find_if(among, [&](const OutputSpec& one) { return is_same_output(one, output); });
    };
    Change change;
    for (const OutputSpec& output : before)
        if (find(now, output) == now.end()) change.gone.push_back(output);
    for (const OutputSpec& output : now) {
        const auto old = find(before, output);
        auto& list = old == before.end()                              ? change.added
                     : all_options_of(*old) == all_options_of(output) ? change.kept
                                                                      : change.changed;
        list.push_back(output);
    }
    return change;
}

}  // namespace camrig::stream
