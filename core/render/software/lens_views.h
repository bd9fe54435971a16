#pragma once

#include <algorithm>
#include <map>
#include <memory>

#include "core/render/renderer.h"
#include "core/render/scene/lens_view.h"
#include "core/render/software/lens_rays.h"

namespace camrig::render::software {

/// What a camera is looked through. Without a lens: neither.
struct ViewLens {
    std::shared_ptr<const scene::LensView> view;
    std::shared_ptr<const LensRays> rays;
};

/// The lens of each camera, made anew when its optics change. Cameras with the same optics share theirs.
class LensViews {
public:
    /// wide_lanes: as of LensRays.
    explicit LensViews(bool wide_lanes) : wide_lanes_(wide_lanes) {}

    /// Refuses what LensView refuses.
    const Result<ViewLens>& of(const View& view) {
        static const Result<ViewLens> pinhole;
        const world::CameraSpec& spec = *view.spec;
        if (spec.lens.model == camera::LensModel::pinhole) {
            entries_.erase(view.camera);
            return pinhole;
        }
        const auto is_same = [&](const auto& entry) {
            return entry.second.size == spec.size && entry.second.intrinsics == spec.intrinsics &&
                   entry.second.lens == spec.lens;
        };
        const auto own = entries_.find(view.camera);
        if (own != entries_.end() && is_same(*own)) return own->second.made;
        const auto other = std::ranges::find_if(entries_, is_same);
        const Entry made =
            other != entries_.end() ? other->second : Entry{spec.size, spec.intrinsics, spec.lens, make(spec)};
        return entries_.insert_or_assign(view.camera, made).first->second.made;
    }
    void forget(CameraId camera) { entries_.erase(camera); }

private:
    struct Entry {
        ImageSize size;
        camera::Intrinsics intrinsics;
        camera::Lens lens;
        Result<ViewLens> made;
    };
    Result<ViewLens> make(const world::CameraSpec& spec) const {
        auto view = scene::LensView::create(spec.size, spec.intrinsics, spec.lens);
        if (!view) return std::unexpected(view.error());
        return ViewLens{*view, std::make_shared<const LensRays>(**view, wide_lanes_)};
    }

    bool wide_lanes_;
    std::map<CameraId, Entry> entries_;
};

}  // namespace camrig::render::software
