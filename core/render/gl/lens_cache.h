#pragma once

#include <map>
#include <memory>

#include "core/base/ids.h"
#include "core/render/gl/gl_objects.h"
#include "core/render/lens_plan.h"
#include "core/world/camera_spec.h"

namespace camrig::render::gl {

/// A plan whose maps are on the device; those are not kept in host memory.
struct LensOnDevice {
    LensPlan plan;        ///< without map and footprint
    GlTexture map;        ///< RG32I
    GlTexture footprint;  ///< RGBA32F; only with supersampling

    /// Metres along the tiles' axes, one per pixel, become metres along the optical axis.
    void to_optical_axis(std::span<float> depth) const;
};

/// Plans by what they follow from: cameras with the same optics share one, and a camera that only moves keeps its own.
class LensCache {
public:
    LensCache(const GlFunctions& gl, int max_side) : gl_(gl), max_side_(max_side) {}

    /// Null for a camera that needs none: no lens, or one that changes nothing, and no method forced on it. Making a
    /// plan takes a fraction of a second for large pictures; a plan that failed is not tried again.
    Result<std::shared_ptr<const LensOnDevice>> lens_of(CameraId camera, const world::CameraSpec& spec,
                                                        world::Antialias antialias);
    void forget(CameraId camera) { of_camera_.erase(camera); }

private:
    struct Key {
        ImageSize size;
        camera::Intrinsics intrinsics;
        camera::Lens lens;
        world::LensSampling sampling;
        int supersampling = 1;
        int multisampling = 1;
        friend bool operator==(const Key&, const Key&) = default;
    };
    struct Entry {
        Key key;
        Result<LensOnDevice> lens;
    };
    Result<LensOnDevice> make(const Key& key) const;

    const GlFunctions& gl_;
    int max_side_;
    std::map<CameraId, std::shared_ptr<const Entry>> of_camera_;
};

}  // namespace camrig::render::gl
