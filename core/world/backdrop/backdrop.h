#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <vector>

#include "core/base/pixel_rect.h"
#include "core/base/result.h"
#include "core/camera/camera_model.h"
#include "core/world/backdrop/backdrop_spec.h"
#include "core/world/backdrop/depth_pieces.h"
#include "core/world/backdrop/film_player.h"
#include "core/world/backdrop/panorama.h"
#include "core/world/camera_spec.h"
#include "core/world/snapshot.h"

namespace camrig::world {

/// What the files of a backdrop hold.
struct BackdropFiles {
    Image picture;                             ///< of a plate
    std::shared_ptr<const Image> scaled;       ///< to the camera's size, where that was known; null: it was not
    std::shared_ptr<const FilmFile> film;      ///< of a film, else null
    std::shared_ptr<const Panorama> panorama;  ///< of a panorama, else null
    /// Of a projected picture, else null.
    std::shared_ptr<const PicturePyramid> projected;
    ModelRef proxies;                               ///< null: none
    ModelRef catchers;                              ///< of the same file; null: none
    std::vector<std::vector<glm::dvec2>> walkable;  ///< of the same file
    /// Of each of the cut-outs, in the picture's pixels; empty: it has no mask.
    std::vector<std::vector<PixelRect>> masks;
    std::vector<DepthPiece> depth;  ///< of the depth image; empty: none

    ImageSize size() const {
        if (projected != nullptr) return projected->levels.front().size;
        return film != nullptr ? film->index.size : picture.size;
    }
};

/// Reads the files that a patch of a camera names for its backdrop, and scales a plate to the size that the patch says;
/// patch_camera_spec needs them. Takes as long as decoding does: not on a thread that pictures wait for. folder: of the
/// scene file, which files lie in or below; empty: they are absolute. Errors have the field's path below the camera
/// ("backdrop.file: ...").
Result<void> load_backdrop(CameraPatch& patch, const std::filesystem::path& folder);

/// A picture that the proxies carry, and the camera that took it.
struct ProjectedPicture {
    std::shared_ptr<const PicturePyramid> picture;
    camera::CameraModel camera;
    camera::Pose pose;
};

/// The backdrop of a camera with this size, optics and pose; a projected one is the same wherever the camera is.
/// Immutable.
struct Backdrop {
    std::shared_ptr<FilmPlayer> film;               ///< null: it is no film
    std::shared_ptr<const Panorama> panorama;       ///< null: it is none
    double yaw_rad = 0.0;                           ///< of the panorama
    std::optional<ProjectedPicture> projected;      ///< nullopt: it is none
    std::vector<Instance> proxies;                  ///< without those of the scene; their id and class number are 0
    std::vector<Instance> catchers;                 ///< such ones that hide nobody: shadows fall on them
    std::vector<IgnoredRegion> ignore;              ///< in the camera's pixels
    std::vector<std::vector<glm::dvec2>> walkable;  ///< polygons in the world; empty: anywhere

    /// Whether each pixel of a view looks its colour up, so that there is no picture() to copy.
    bool is_sampled() const { return panorama != nullptr || projected; }

    /// That of the camera's size, opaque: of a plate, or the film's of that shot; of no other kind. Takes its time:
    /// where it was not scaled yet the first who asks does so, and a film is waited for. Any thread but those that
    /// nobody may hold up.
    std::shared_ptr<const Image> picture(const FilmShot& shot) const;

    ImageSize size;                              ///< the camera's
    std::shared_ptr<const BackdropFiles> files;  ///< of a plate

private:
    mutable std::once_flag once_;
    mutable std::shared_ptr<const Image> picture_;
};

/// The picture is scaled, in linear light, by the area of it that a pixel of the camera sees, and otherwise its bytes
/// are the file's. What is given in pixels is carried to the world through the camera's lens. Errors: load_backdrop was
/// not called, the picture's sides are of another ratio, shapes over the horizon, behind the camera or crossing
/// themselves.
Result<std::shared_ptr<const Backdrop>> make_backdrop(const CameraSpec& spec);

/// Whether pictures of these sizes have the same ratio of their sides, but for half a pixel.
bool has_sides_of(ImageSize picture, ImageSize size);

/// Intrinsics of a picture as those of the same picture in another size.
camera::Intrinsics scaled(const camera::Intrinsics& k, ImageSize from, ImageSize to);

}  // namespace camrig::world
