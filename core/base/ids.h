#pragma once

#include <cstdint>

namespace camrig {

/// One life of one camera: a camera that is deleted and created again under the same name gets a new id. Never reused,
/// never 0.
enum class CameraId : std::uint32_t {};

/// An object of the world (static object, actor, prop); the same in every camera and in the truth. 0 is "nothing".
enum class ObjectId : std::uint32_t {};

}  // namespace camrig
