#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "core/base/ids.h"

namespace camrig::unrealcv {

using Rgb = std::array<std::uint8_t, 3>;

/// In which colours objects are drawn in masks. Without a command each has one of 32^3 by its id: channels have 32
/// levels, 0, 15, 23 .. 255, so that any two colours are at least 8 apart in one channel (clients compare with a
/// tolerance of 3), and none is black, which is where nothing is. The 32768th object has that of the first again.
class Colors {
public:
    static Rgb own_color(ObjectId object);

    Rgb of(ObjectId object) const {
        const auto set = set_.find(object);
        return set == set_.end() ? own_color(object) : set->second;
    }
    void set(ObjectId object, Rgb color) { set_[object] = color; }
    /// There is another world.
    void clear() { set_.clear(); }

private:
    std::map<ObjectId, Rgb> set_;
};

/// "(R=127,G=0,B=0,A=255)", as FColor::ToString prints it.
std::string text_of(const Rgb& color);

}  // namespace camrig::unrealcv
