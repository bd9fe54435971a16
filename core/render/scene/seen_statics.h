#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/render/renderer.h"
#include "core/render/scene/scene_view.h"

namespace camrig::render::scene {

/// Numbers what a camera shows of what stands still, for its StaticLayerKey. Lights change by commands and events, a
/// lamp that flickers many times a second: whoever does not see what it shines on keeps the number, and the layer.
///
/// What the static surfaces of a picture look like follows from the lights that reach them, one of which may be
/// stronger than another: so from the values of all lights that are in any of their light sets, in their order. Not of
/// those whose range ends beside the picture. At quality beautiful every light counts: which of them have shadow maps
/// depends on all.
class SeenStatics {
public:
    /// The same as of the camera's last view: nothing that stands still looks different in this one.
    std::uint64_t number_of(const View& view, const SceneView& scene);
    /// The camera's last view was one of the scene's present static set.
    bool is_of(CameraId camera, const PlacedScene& scene) const {
        const auto found = seen_.find(camera);
        return found != seen_.end() && found->second.statics == scene.statics_number();
    }
    void forget(CameraId camera) { seen_.erase(camera); }
    void clear() { seen_.clear(); }

private:
    struct Seen {
        std::uint64_t number = 0;  ///< 0: no view yet
        std::uint64_t spec_revision = 0;
        camera::Pose pose;
        world::Quality quality = world::Quality::simple;
        std::uint64_t statics = 0, objects = 0, proxies = 0;  ///< as the scene counts them
        world::Environment environment;
        /// None: not looked for. A camera that moves never needs them.
        std::optional<std::vector<world::Light>> lights;
    };

    std::map<CameraId, Seen> seen_;
    std::uint64_t last_ = 0;
};

}  // namespace camrig::render::scene
