#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "core/base/field_table.h"
#include "core/base/named.h"
#include "core/base/rate.h"
#include "core/camera/intrinsics.h"
#include "core/camera/lens.h"
#include "core/camera/pose.h"

/// What a user says of a picture of a real place that people walk in (docs/backdrops.md). Pixels are those of the
/// picture as its file has it, centres at integers; metres are the world's.
namespace camrig::world {

struct BackdropFiles;

/// plate: one picture of a camera that stands still. film: one after the other, of the same. panorama: what is all
/// around a camera that may turn and zoom. projected: one picture, which the proxies carry, of a camera that moves a
/// little about where it was taken.
enum class BackdropKind : std::uint8_t { plate, film, panorama, projected };
std::span<const Named<BackdropKind>> names_of(std::type_identity<BackdropKind>);

/// What objects of the scene that stand still are to the picture. drawn: they stand in the place and are drawn into
/// it. proxies: the picture shows them already. hidden: they are not there.
enum class SceneInBackdrop : std::uint8_t { drawn, proxies, hidden };
std::span<const Named<SceneInBackdrop>> names_of(std::type_identity<SceneInBackdrop>);

/// What a shape does. catcher: shadows fall on it, and it hides nobody; holdout: it hides who goes behind it, and no
/// shadow falls on it.
enum class ProxyRole : std::uint8_t { both, catcher, holdout };
std::span<const Named<ProxyRole>> names_of(std::type_identity<ProxyRole>);

/// A piece of level ground. One of the polygons.
struct LevelGround {
    std::vector<glm::dvec2> polygon_m, polygon_px;
    double z = 0.0;
    friend bool operator==(const LevelGround&, const LevelGround&) = default;
};
FieldTable<LevelGround> fields_of(std::type_identity<LevelGround>);

/// Such a piece as a shape.
struct GroundProxy {
    std::vector<glm::dvec2> polygon_m, polygon_px;
    double z = 0.0;
    ProxyRole role = ProxyRole::both;
    LevelGround where() const { return {polygon_m, polygon_px, z}; }
    friend bool operator==(const GroundProxy&, const GroundProxy&) = default;
};
FieldTable<GroundProxy> fields_of(std::type_identity<GroundProxy>);

/// Stands on the middle of its bottom.
struct BoxProxy {
    glm::dvec3 position{0.0};
    glm::dvec3 size{1.0};
    double yaw_deg = 0.0;  ///< about z, counter-clockwise
    ProxyRole role = ProxyRole::both;
    friend bool operator==(const BoxProxy&, const BoxProxy&) = default;
};
FieldTable<BoxProxy> fields_of(std::type_identity<BoxProxy>);

/// What the picture shows within the polygon, or where the mask marks it, stands upright where its foot is on the
/// ground, and faces the camera.
struct CutoutProxy {
    std::vector<glm::dvec2> polygon_px;
    std::string mask;  ///< a picture of the same size; empty: the polygon counts
    glm::dvec2 foot_px{0.0};
    double z = 0.0;  ///< of the ground at its foot
    ProxyRole role = ProxyRole::both;
    friend bool operator==(const CutoutProxy&, const CutoutProxy&) = default;
};
FieldTable<CutoutProxy> fields_of(std::type_identity<CutoutProxy>);

/// What the numbers of a depth image are: metres along the camera's axis, or to its eye.
enum class DepthMeasure : std::uint8_t { z, range };
std::span<const Named<DepthMeasure>> names_of(std::type_identity<DepthMeasure>);

/// How far away each pixel of the picture is, as stereo, a laser scanner or a network tells.
struct DepthProxy {
    std::string file;       ///< a PNG of 16-bit gray, of the picture's size; 0: nothing there
    double unit_m = 0.001;  ///< of its numbers
    DepthMeasure measure = DepthMeasure::z;
    ProxyRole role = ProxyRole::both;
    friend bool operator==(const DepthProxy&, const DepthProxy&) = default;
};
FieldTable<DepthProxy> fields_of(std::type_identity<DepthProxy>);

/// The shapes of what the picture shows: they hide what goes behind them, and shadows fall on them, unless their role
/// is one of both only.
struct ProxiesSpec {
    std::string file;  ///< glTF, in the world's place; empty: none
    std::optional<GroundProxy> ground;
    std::vector<BoxProxy> boxes;
    std::vector<CutoutProxy> cutouts;
    std::optional<DepthProxy> depth;
    std::vector<LevelGround> walkable;  ///< where people may go; no shapes. Empty: anywhere
    SceneInBackdrop scene = SceneInBackdrop::drawn;
    friend bool operator==(const ProxiesSpec&, const ProxiesSpec&) = default;

    bool is_empty() const {
        return file.empty() && !ground && boxes.empty() && cutouts.empty() && !depth &&
               scene != SceneInBackdrop::proxies;
    }
};
FieldTable<ProxiesSpec> fields_of(std::type_identity<ProxiesSpec>);

/// The shadows of what moves on what the picture shows. blob: about feet; mapped: of the lights, at quality beautiful,
/// else as blob.
enum class BackdropShadow : std::uint8_t { none, blob, mapped };
std::span<const Named<BackdropShadow>> names_of(std::type_identity<BackdropShadow>);

/// Of the picture, in codes of 255: its standard deviation at a level of 0 to 255 is sqrt(read^2 + k * level).
struct PlateNoise {
    double k = 0.0, read = 0.0;
    friend bool operator==(const PlateNoise&, const PlateNoise&) = default;
};
FieldTable<PlateNoise> fields_of(std::type_identity<PlateNoise>);

/// Where the picture shows something real that truth does not know: a person of that moment.
struct IgnoredRegion {
    std::vector<glm::dvec2> polygon_px;
    std::string object_class = "person";
    friend bool operator==(const IgnoredRegion&, const IgnoredRegion&) = default;
};
FieldTable<IgnoredRegion> fields_of(std::type_identity<IgnoredRegion>);

/// A part of a panorama in finer pixels: as of a panorama with `scale` times its columns, of which this is what lies
/// from at_px on, to the right and below.
struct PanoramaDetail {
    std::string file;
    int scale = 2;
    glm::ivec2 at_px{0};
    friend bool operator==(const PanoramaDetail&, const PanoramaDetail&) = default;
};
FieldTable<PanoramaDetail> fields_of(std::type_identity<PanoramaDetail>);

struct BackdropSpec {
    bool is_panorama() const { return kind == BackdropKind::panorama; }
    bool is_projected() const { return kind == BackdropKind::projected; }
    /// The picture is true from one place, in one direction and at one zoom only.
    bool stands_still() const { return !is_panorama() && !is_projected(); }

    BackdropKind kind = BackdropKind::plate;
    std::string file;
    std::optional<Rate> fps;                       ///< of a film; nullopt: what the file says
    double yaw_deg = 0.0;                          ///< of a panorama: which way its middle looks
    std::vector<PanoramaDetail> details;           ///< of a panorama
    std::optional<camera::Intrinsics> intrinsics;  ///< of the picture's own pixels; nullopt: the camera's
    std::optional<camera::Pose> taken_from;        ///< of a projected picture
    std::optional<camera::Lens> lens;              ///< of a projected picture; nullopt: the camera's
    ProxiesSpec proxies;
    BackdropShadow shadow = BackdropShadow::mapped;
    glm::dvec3 plate_gain{1.0};       ///< factor on the light of what is drawn, per channel
    double edge_px = 0.0;             ///< standard deviation of the Gaussian that the picture's edges are soft by
    std::optional<PlateNoise> noise;  ///< put on what is drawn; nullopt: none
    std::vector<IgnoredRegion> ignore;
    std::shared_ptr<const BackdropFiles> files;  ///< read by load_backdrop
    friend bool operator==(const BackdropSpec&, const BackdropSpec&) = default;
};
FieldTable<BackdropSpec> fields_of(std::type_identity<BackdropSpec>);

}  // namespace camrig::world
