#pragma once

#include <map>

#include "core/render/renderer.h"
#include "core/render/scene/lens_view.h"

namespace camrig {

/// The lens of each camera, made anew when its optics change.
class LensViews {
public:
    /// Null for a pinhole. Refuses what LensView refuses.
    Result<std::shared_ptr<const LensView>> of(const View& view) {
        const CameraSpec& spec = *view.spec;
        if (spec.lens.model == LensModel::pinhole) {
            entries_.erase(view.camera);
            return nullptr;
        }
        Entry& entry = entries_[view.camera];
        if (entry.size != spec.size || entry.intrinsics != spec.intrinsics || entry.lens != spec.lens) {
            entry = {spec.size, spec.intrinsics, spec.lens, LensView::create(spec.size, spec.intrinsics, spec.lens)};
        }
        return entry.view;
    }
    void forget(CameraId camera) { entries_.erase(camera); }

private:
    struct Entry {
        ImageSize size;
        Intrinsics intrinsics;
        Lens lens;
        Result<std::shared_ptr<const LensView>> view = nullptr;
    };
    std::map<CameraId, Entry> entries_;
};

}  // namespace camrig
