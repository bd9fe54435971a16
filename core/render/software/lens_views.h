#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "core/render/renderer.h"
#include "core/render/scene/lens_view.h"
#include "core/render/software/lens_rays.h"

namespace camrig::render::software {

/// What a camera is looked through. Without a lens: neither.
struct ViewLens {
    std::shared_ptr<const scene::LensView> view;
    std::shared_ptr<const LensRays> rays;
};

/// The lens of each camera, made anew when its optics change. Cameras with the same optics share theirs. Any thread.
class LensViews {
public:
    /// Refuses what LensView refuses. wide_lanes: as of LensRays.
    Result<ViewLens> of(const View& view, bool wide_lanes) {
        const world::CameraSpec& spec = *view.spec;
        if (spec.lens.model == camera::LensModel::pinhole) {
            forget(view.camera);
            return {};
        }
        if (const auto found = find(view)) return *found;
        // Others may ask for theirs meanwhile.
        Entry entry{spec.size, spec.intrinsics, spec.lens, make(spec, wide_lanes)};
        const std::lock_guard lock(mutex_);
        return entries_.insert_or_assign(view.camera, std::move(entry)).first->second.made;
    }
    void forget(CameraId camera) {
        const std::lock_guard lock(mutex_);
        entries_.erase(camera);
    }

private:
    struct Entry {
        ImageSize size;
        camera::Intrinsics intrinsics;
        camera::Lens lens;
        Result<ViewLens> made;
    };
    /// The camera's own, or that of another one, which becomes its own.
    std::optional<Result<ViewLens>> find(const View& view) {
        const auto is_same = [&spec = *view.spec](const auto& entry) {
            return entry.second.size == spec.size && entry.second.intrinsics == spec.intrinsics &&
                   entry.second.lens == spec.lens;
        };
        const std::lock_guard lock(mutex_);
        if (const auto own = entries_.find(view.camera); own != entries_.end() && is_same(*own))
            return own->second.made;
        const auto other = std::ranges::find_if(entries_, is_same);
        if (other == entries_.end()) return std::nullopt;
        return entries_.insert_or_assign(view.camera, Entry(other->second)).first->second.made;
    }
    static Result<ViewLens> make(const world::CameraSpec& spec, bool wide_lanes) {
        auto view = scene::LensView::create(spec.size, spec.intrinsics, spec.lens);
        if (!view) return std::unexpected(view.error());
        return ViewLens{*view, std::make_shared<const LensRays>(**view, wide_lanes)};
    }

    std::mutex mutex_;
    std::map<CameraId, Entry> entries_;
};

}  // namespace camrig::render::software
