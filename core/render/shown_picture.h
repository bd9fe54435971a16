#pragma once

#include <cstdint>

#include "core/frame/changed_rows.h"

namespace camrig {

/// The last colour picture of a camera, for what the next one has in common with it: a kept layer of what stands still,
/// with other things in some rows.
class ShownPicture {
public:
    struct Change {
        std::int64_t same_as = -1;  ///< FrameInfo::same_as and changed_rows
        ChangedRows rows;
    };
    /// The next picture shows this layer (0: none that is kept), but in the drawn rows. A layer is of one revision of
    /// the camera: image controls and everything else are as they were.
    Change next(std::int64_t sequence, std::uint64_t layer, const ChangedRows& drawn) {
        Change change;
        if (layer != 0 && layer == layer_) {
            change.same_as = sequence_;
            change.rows = drawn_;
            change.rows |= drawn;
        }
        sequence_ = sequence;
        layer_ = layer;
        drawn_ = drawn;
        return change;
    }

private:
    std::int64_t sequence_ = -1;
    std::uint64_t layer_ = 0;
    ChangedRows drawn_;
};

}  // namespace camrig
