#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include "core/camera/camera_model.h"
#include "core/render/scene/scene_view.h"
#include "core/render/software/geometry.h"
#include "core/world/camera_past.h"

/// Optical flow: where the points that a view shows will be in a later moment of its camera, less where they are. Each
/// is followed on its own triangle, through the pose of its object and its mesh, and seen by the camera of then.
namespace camrig::render::software {

struct ViewWork;
struct ViewScratch;

/// What a view's draws will be at a later moment. One thread makes it; any may look at it then.
class SceneAhead {
public:
    explicit SceneAhead(std::shared_ptr<scene::PreparedModels> models) : scene_(std::move(models)) {}

    /// What the view's camera sees at `then`. now: as it is placed for the view; it stays so while this is used.
    void begin(const scene::PlacedScene& now, const world::CameraSpec& spec, const ViewTransform& view,
               const world::CameraPast::Moment& then);
    /// Of a deformed mesh the vertices at that time, of the level that is seen; null: it is rigid, or is not there.
    const glm::vec3* positions_of(const scene::SeenSurface& seen);
    /// Follows these draws, by their numbers.
    void follow(std::span<const ViewDraw> draws);
    void clear() { scene_.clear(); }

    /// A draw at that time, in the optical frame of the camera of then.
    struct Draw {
        bool is_there = false;
        bool is_still = false;     ///< before a camera that stands still too
        glm::dmat4 from_now{1.0};  ///< of the optical frame of now, if it is rigid
        const glm::vec3* positions = nullptr;
        glm::dmat4 from_local{1.0};
    };
    const Draw& draw(std::size_t number) const { return draws_[number]; }
    const camera::CameraModel& camera() const { return *camera_; }

private:
    using Firsts = std::unordered_map<ObjectId, const scene::PlacedSurface*>;
    static void find_firsts(const scene::PlacedScene& scene, Firsts& firsts);
    /// Itself where it is none of the scene's, but of a backdrop's, which stands still.
    const scene::PlacedSurface* then_of(const scene::SeenSurface& seen) const;

    const scene::PlacedScene* now_ = nullptr;
    scene::PlacedScene scene_;
    ViewTransform view_, view_then_;
    bool camera_stands_ = false;
    std::optional<camera::CameraModel> camera_;
    Firsts firsts_now_, firsts_then_;  ///< the first surface of each object
    std::vector<Draw> draws_;
};

/// Writes the flow of the pixels of the rectangle that have a triangle.
void describe_flow(const ViewScratch& scratch, const PixelRect& rect, ViewWork& work);

}  // namespace camrig::render::software
