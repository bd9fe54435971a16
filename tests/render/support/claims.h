#pragma once

#include <algorithm>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "core/frame/frame.h"

namespace camrig::render {

/// Whether all bytes of a frame in the bands that it calls unchanged are those of the frame that it names.
class Claims {
public:
    void check(const frame::FrameRef& frame, const std::string& what) {
        const frame::FrameInfo& info = frame->info();
        auto& earlier = frames_[info.camera_id];
        ++count;
        if (const auto base = info.damage.base()) {
            ++named;
            ASSERT_TRUE(earlier.contains(*base)) << what << ": no frame " << *base << " before";
            const frame::Frame& other = *earlier[*base];
            ASSERT_EQ(other.info().size, info.size) << what;
            const auto row_bytes = static_cast<std::size_t>(info.size.width) * 4;
            for (int y = 0; y < info.size.height; ++y) {
                ++rows;
                if (info.damage.contains_band(y / frame::Damage::band_rows)) continue;
                ++unchanged;
                const std::size_t at = static_cast<std::size_t>(y) * row_bytes;
                ASSERT_TRUE(
                    std::ranges::equal(frame->bytes().subspan(at, row_bytes), other.bytes().subspan(at, row_bytes)))
                    << what << ", row " << y;
            }
        }
        earlier[info.sequence] = frame;
    }
    double unchanged_share() const { return static_cast<double>(unchanged) / rows; }

    int count = 0, named = 0;
    std::int64_t rows = 0, unchanged = 0;

private:
    std::map<CameraId, std::map<std::int64_t, frame::FrameRef>> frames_;
};

}  // namespace camrig::render
