#pragma once

#include "core/frame/damage.h"

namespace camrig::render {

/// The last colour picture of a camera, for the damage of the next one: both are a kept layer of what stands still,
/// with other things in some rows.
class ShownPicture {
public:
    /// The next picture differs from a layer by this much (its base is the layer's number); unknown when none is kept.
    /// A layer is of one revision of the camera: image controls and everything else are as they were.
    frame::Damage next(std::int64_t sequence, const frame::Damage& since_layer) {
        const frame::Damage damage = frame::Damage::between(sequence_, since_layer_, since_layer);
        // A picture that a command changed is drawn again under its number, which names no base then.
        is_drawn_anew_ = sequence == sequence_ && (is_drawn_anew_ || since_layer.base() != since_layer_.base());
        sequence_ = sequence;
        since_layer_ = is_drawn_anew_ ? frame::Damage{} : since_layer;
        return damage;
    }

private:
    std::int64_t sequence_ = -1;
    frame::Damage since_layer_;
    bool is_drawn_anew_ = false;
};

}  // namespace camrig::render
