#pragma once

#include <list>

#include "core/render/gl/view_target.h"

namespace camrig::render::gl {

/// Pictures that exist only between the draws of a view and what is made of them: sources of lenses, samples that are
/// resolved. Views of the same size share one, since the device works in order. What nobody asked for during
/// `kept_instants` is freed. Pointers are good until next_instant().
class ScratchTargets {
public:
    explicit ScratchTargets(const GlFunctions& gl) : gl_(gl) {}
    Result<const ColorTarget*> color(ImageSize size, const ColorTargetOptions& options);
    Result<const TruthTarget*> truth(ImageSize size);
    void next_instant();

    static constexpr int kept_instants = 64;

private:
    template <typename T>
    struct Kept {
        T target;
        int idle = 0;
    };
    const GlFunctions& gl_;
    std::list<Kept<ColorTarget>> colors_;
    std::list<Kept<TruthTarget>> truths_;
};

}  // namespace camrig::render::gl
