#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "control/unrealcv/colors.h"
#include "core/base/result.h"
#include "core/camera/intrinsics.h"
#include "core/camera/lens.h"
#include "core/codec/bytes_recycler.h"
#include "core/codec/encoder.h"
#include "core/frame/frame_pool.h"

namespace camrig::unrealcv {

/// The files that pictures come as: PNG and BMP with four channels (clients cut the last one off), NumPy arrays.
enum class FileType : std::uint8_t { png, bmp, npy };
std::optional<FileType> file_type(std::string_view ending);

/// Buffers and encoders for files of pictures, used again by later ones: to map megabytes anew for each picture takes
/// longer than to fill them. Any thread.
class PictureMemory {
public:
    std::shared_ptr<std::vector<std::byte>> file() { return files_.acquire(); }
    std::shared_ptr<frame::Frame> frame(frame::FrameInfo info) { return frames_.acquire(std::move(info)); }
    /// With alpha, quick rather than small.
    Result<codec::BytesRef> png(const frame::Frame& rgba);

private:
    static constexpr std::size_t max_idle_bytes = std::size_t{64} << 20;
    static constexpr std::size_t max_idle_encoders = 2;

    codec::BytesRecycler files_;
    frame::FramePool frames_{max_idle_bytes};
    std::mutex mutex_;
    std::vector<std::unique_ptr<codec::Encoder>> encoders_;  ///< idle
};

/// rgba8 as it is. The masks and normals are given as rgba8 too.
Result<codec::BytesRef> encode_picture(PictureMemory& memory, const frame::Frame& rgba, FileType type);

/// An instance picture in the objects' colours.
frame::FrameRef mask_of(PictureMemory& memory, const frame::Frame& ids, const Colors& colors);
/// Normals of the optical frame as UnrealCV shows them: in the world, left-handed, (n + 1) / 2 in red, green and blue.
frame::FrameRef shown_normals(PictureMemory& memory, const frame::Frame& normals, const glm::dmat3& world_from_optical);

/// Optical flow as a colour wheel: the hue is the way (red to the right, then by yellow down), full at
/// full_flow_px, black where nothing is.
frame::FrameRef shown_flow(PictureMemory& memory, const frame::Frame& flow);
inline constexpr float full_flow_px = 20.0f;
/// float32 of height x width x 2, pixels until the camera's next frame; NaN where nothing is.
codec::BytesRef flow_array(PictureMemory& memory, const frame::Frame& flow);

enum class Depth : std::uint8_t {
    plane_cm,  ///< along the optical axis, centimetres: the plugin's of Unreal Engine 4.27 and 5
    plane_m,   ///< the same in metres: `plane_depth` of 0.3.10
    ray_m,     ///< along each pixel's ray, metres: `depth` of 0.3.10
};
/// What the plugin has where nothing is: the largest half-float.
inline constexpr float depth_of_nothing = 65504.0f;
/// float32 of height x width, as numpy.save writes it.
Result<codec::BytesRef> depth_array(PictureMemory& memory, const frame::Frame& depth, Depth how,
                                    const camera::Intrinsics& intrinsics, const camera::Lens& lens);

}  // namespace camrig::unrealcv
