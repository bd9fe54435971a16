#include "core/render/gl/scratch_targets.h"

namespace camrig::render::gl {

Result<const ColorTarget*> ScratchTargets::color(ImageSize size, const ColorTargetOptions& options) {
    for (auto& [target, idle] : colors_) {
        const bool has_depth = static_cast<bool>(target.depth);
        if (target.size != size || target.samples != options.samples || has_depth != options.has_depth) continue;
        idle = 0;
        return &target;
    }
    auto made = make_color_target(gl_, size, options);
    if (!made) return std::unexpected(made.error());
    return &colors_.emplace_back(std::move(*made)).target;
}

Result<const TruthTarget*> ScratchTargets::truth(ImageSize size) {
    for (auto& [target, idle] : truths_) {
        if (target.size != size) continue;
        idle = 0;
        return &target;
    }
    auto made = make_truth_target(gl_, size);
    if (!made) return std::unexpected(made.error());
    return &truths_.emplace_back(std::move(*made)).target;
}

void ScratchTargets::next_instant() {
    const auto is_old = [](auto& kept) { return ++kept.idle > kept_instants; };
    std::erase_if(colors_, is_old);
    std::erase_if(truths_, is_old);
}

}  // namespace camrig::render::gl
