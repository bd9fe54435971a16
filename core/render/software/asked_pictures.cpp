#include "core/render/software/asked_pictures.h"

#include <utility>

namespace camrig::render::software {

void AskedPictures::next_instant() {
    ++instant_;
    for (auto& [camera, asked] : cameras_) asked.frames = {};
}

KindSet AskedPictures::to_draw(const View& view, KindSet wanted, const std::function<bool(frame::FrameKind)>& can_draw,
                               OfCamera*& kept) {
    kept = nullptr;
    if (!view.only_objects.empty()) return wanted;
    OfCamera& asked = cameras_[view.camera];
    if (asked.instant != instant_) asked.before = std::exchange(asked.now, {});
    if (asked.instant != instant_ || asked.spec_revision != view.spec_revision || asked.pose != view.pose ||
        asked.quality != view.quality || asked.sequence != view.sequence) {
        asked.instant = instant_;
        asked.spec_revision = view.spec_revision;
        asked.pose = view.pose;
        asked.quality = view.quality;
        asked.sequence = view.sequence;
        asked.frames = {};
    }
    asked.now |= wanted;
    if ((asked.now | asked.before).count() > 1) kept = &asked;
    KindSet missing = wanted;
    for (std::size_t k = 0; k < missing.size(); ++k) missing[k] = missing[k] && asked.frames[k] == nullptr;
    if (missing.none() || kept == nullptr) return missing;
    for (std::size_t k = 0; k < missing.size(); ++k)
        missing[k] =
            missing[k] || (asked.before[k] && asked.frames[k] == nullptr && can_draw(static_cast<frame::FrameKind>(k)));
    return missing;
}

}  // namespace camrig::render::software
