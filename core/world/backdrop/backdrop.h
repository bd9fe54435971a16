#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "core/base/result.h"
#include "core/world/backdrop/backdrop_spec.h"
#include "core/world/camera_spec.h"
#include "core/world/snapshot.h"

namespace camrig::world {

/// What the files of a backdrop hold.
struct BackdropFiles {
    Image picture;
    ModelRef proxies;  ///< null: none
};

/// Reads the files that a patch of a camera names for its backdrop; patch_camera_spec needs them. Takes as long as
/// decoding does: not on a thread that pictures wait for. folder: of the scene file, which files lie in or below;
/// empty: they are absolute. Errors have the field's path below the camera ("backdrop.file: ...").
Result<void> load_backdrop(CameraPatch& patch, const std::filesystem::path& folder);

/// The backdrop of a camera with this size, optics and pose. Immutable.
struct Backdrop {
    Image picture;                      ///< of the camera's size, opaque
    std::vector<Instance> proxies;      ///< without those of the scene; their id and class number are 0
    std::vector<IgnoredRegion> ignore;  ///< in the camera's pixels
};

/// The picture is scaled, in linear light, by the area of it that a pixel of the camera sees, and otherwise its bytes
/// are the file's. What is given in pixels is carried to the world through the camera's lens. Errors: load_backdrop was
/// not called, the picture's sides are of another ratio, shapes over the horizon, behind the camera or crossing
/// themselves.
Result<std::shared_ptr<const Backdrop>> make_backdrop(const CameraSpec& spec);

/// Intrinsics of a picture as those of the same picture in another size.
camera::Intrinsics scaled(const camera::Intrinsics& k, ImageSize from, ImageSize to);

}  // namespace camrig::world
