#include "tools/camrig/loopback_outputs.h"

namespace camrig {

LoopbackOutputs::LoopbackOutputs(FrameBus& bus, FrameFetcher& fetcher, LoopbackHost::Options options)
    : bus_(bus), server_(bus, fetcher, options) {
    bus_.add_observer(this);
}

LoopbackOutputs::~LoopbackOutputs() {
    bus_.remove_observer(this);
}

void LoopbackOutputs::camera_added(const CameraStream& camera) {
    plug(camera, true);
}

void LoopbackOutputs::camera_changed(const CameraStream& camera) {
    plug(camera, true);
}

void LoopbackOutputs::camera_removed(const CameraStream& camera) {
    plug(camera, false);
}

void LoopbackOutputs::plug(const CameraStream& camera, bool is_there) {
    std::map<int, LoopbackFormat> wanted;
    for (const OutputSpec& output : camera.outputs)
        if (is_there && output.kind == "v4l2" && output.number)
            wanted.emplace(*output.number, loopback_format_of(camera, output));
    for (auto it = plugged_.begin(); it != plugged_.end();) {
        if (it->second != camera.name || wanted.contains(it->first)) {
            ++it;
            continue;
        }
        server_.unset(it->first);
        it = plugged_.erase(it);
    }
    for (const auto& [number, format] : wanted) {
        server_.set({number, camera.name, format});
        plugged_[number] = camera.name;
    }
}

}  // namespace camrig
