#include "core/truth/make_truth.h"

#include <algorithm>
#include <cmath>

#include "core/camera/camera_model.h"
#include "core/camera/lens_traits.h"
#include "core/fault/mask.h"
#include "core/truth/id_census.h"
#include "core/truth/posed_object.h"
#include "core/truth/projected_box.h"
#include "core/truth/view_cone.h"

namespace camrig::truth {
namespace {

/// Rasterisers round to their sub-pixel grid: an object may show this far outside of its exact box.
constexpr int box_margin_px = 2;

std::span<const float> depths_of(const frame::Frame& frame) {
    return {reinterpret_cast<const float*>(frame.bytes().data()), frame.bytes().size() / sizeof(float)};
}

}  // namespace

struct StandingObjects::Found {
    /// An object on its way into the truth.
    struct Candidate {
        ObjectTruth truth;
        PixelBox reach;  ///< the pixels that may show it
    };

    std::weak_ptr<const world::StaticSet> statics;
    std::shared_ptr<const world::CameraSpec> spec;
    camera::Pose pose;
    std::vector<std::optional<Candidate>> candidates;  ///< of the statics' objects; none: beside the picture
};

StandingObjects::StandingObjects() : found_(std::make_unique<Found>()) {}
StandingObjects::~StandingObjects() = default;

class TruthMaker {
public:
    TruthMaker(const TruthView& view, const camera::CameraModel& camera, const TruthPictures& pictures)
        : view_(view),
          camera_(camera),
          pictures_(pictures),
          cone_(camera),
          projector_(camera, view.spec->near_m, view.spec->far_m),
          optical_from_world_(glm::transpose(world_from_optical_rotation(view.pose))),
          counts_(count_ids(ids_of(*pictures.instance), view.spec->size)) {
        if (view.rows) rolling_.emplace(*view.rows, camera);
        if (view.faults && fault::hides_scene(*view.faults))
            soiled_ = count_soiled(ids_of(*pictures.instance), fault::hidden_mask(view.faults.get(), view.spec->size));
    }

    /// All of the snapshot's objects.
    Result<void> measure(const world::Snapshot& snapshot, StandingObjects* standing);
    Result<std::vector<ObjectTruth>> finish(const FindSilhouettes& find_silhouettes);

private:
    using Candidate = StandingObjects::Found::Candidate;

    Result<void> measure(const world::Instance& instance);
    static glm::dvec3 world_of(const PosedObject& object, const glm::dvec3& own) {
        return object.position() + object.orientation() * own;
    }
    /// As it is in another snapshot, or as here if it is not there.
    static void pose_as_in(const world::Snapshot& snapshot, const world::Instance& instance, PosedObject& object);
    /// Relative to the eye in double before anything else: exact however far out the world is.
    glm::dvec3 optical(const glm::dvec3& world) const { return optical_from_world_ * (world - view_.pose.position); }
    std::optional<PixelBox> reach_of(const ProjectedBox& box) const;
    double truncation_of(const ProjectedBox& box) const;
    std::vector<Keypoint> keypoints_of(const world::Instance& instance);
    KeypointVisibility visibility_of(const Keypoint& point, const glm::dvec3& seen, double tolerance_m,
                                     ObjectId id) const;
    void account(ObjectTruth& truth, const frame::Silhouette& alone) const;

    const TruthView& view_;
    const camera::CameraModel& camera_;
    const TruthPictures& pictures_;
    ViewCone cone_;
    BoxProjector projector_;
    glm::dmat3 optical_from_world_;
    std::unordered_map<std::uint32_t, IdCount> counts_;
    std::unordered_map<std::uint32_t, std::int64_t> soiled_;
    std::optional<RollingEye> rolling_;
    PosedObject object_;
    PosedObject first_, last_;  ///< the same where the first and the last row show it
    std::vector<glm::dvec3> points_;
    std::vector<Candidate> candidates_;
};

Result<void> TruthMaker::measure(const world::Snapshot& snapshot, StandingObjects* standing) {
    const auto& objects = snapshot.statics->objects;
    if (standing != nullptr) {
        StandingObjects::Found& found = *standing->found_;
        const bool is_known =
            found.statics.lock() == snapshot.statics && found.spec == view_.spec && found.pose == view_.pose;
        // Known once all of it is found.
        std::vector<std::optional<Candidate>> anew;
        for (std::size_t i = 0; i < objects.size(); ++i) {
            // Whether key points are seen depends on what moves.
            if (is_known && (!found.candidates[i] || found.candidates[i]->truth.keypoints.empty())) {
                if (found.candidates[i]) candidates_.push_back(*found.candidates[i]);
                continue;
            }
            const std::size_t before = candidates_.size();
            if (auto measured = measure(objects[i]); !measured) return measured;
            if (is_known) continue;
            anew.emplace_back();
            if (candidates_.size() > before) anew.back() = candidates_.back();
        }
        if (!is_known)
            found = {
                .statics = snapshot.statics, .spec = view_.spec, .pose = view_.pose, .candidates = std::move(anew)};
    } else {
        for (const world::Instance& instance : objects)
            if (auto measured = measure(instance); !measured) return measured;
    }
    for (const world::Instance& instance : snapshot.movers)
        if (auto measured = measure(instance); !measured) return measured;
    return {};
}

void TruthMaker::pose_as_in(const world::Snapshot& snapshot, const world::Instance& instance, PosedObject& object) {
    const auto found = std::ranges::find(snapshot.movers, instance.info, &world::Instance::info);
    object.pose(found != snapshot.movers.end() ? *found : instance);
    object.place_vertices();
}

Result<void> TruthMaker::measure(const world::Instance& instance) {
    object_.pose(instance);
    const glm::dmat3 optical_from_object = optical_from_world_ * glm::mat3_cast(object_.orientation());
    const glm::dvec3 origin = optical(object_.position());
    // Most of a large world is beside or behind the camera: there is no need to look at its vertices.
    const auto reach_m = object_.reach();
    if (!rolling_ && reach_m && !cone_.may_meet(optical_from_object * reach_m->center + origin, reach_m->radius))
        return {};
    object_.place_vertices();
    if (object_.is_empty()) return {};
    if (rolling_) {
        pose_as_in(rolling_->first(), instance, first_);
        pose_as_in(rolling_->last(), instance, last_);
    }
    ProjectedBox box;
    for (std::size_t n = 0; n < object_.parts().size(); ++n) {
        const PosedObject::Part& part = object_.parts()[n];
        points_.clear();
        for (std::size_t i = 0; i < part.points.size(); ++i) {
            points_.push_back(rolling_ ? rolling_->see(world_of(first_, first_.parts()[n].points[i]),
                                                       world_of(last_, last_.parts()[n].points[i]))
                                       : optical_from_object * part.points[i] + origin);
        }
        if (auto added = projector_.add(points_, *part.primitive, box); !added)
            return at("object " + instance.info->name, added.error());
    }
    const auto reach = reach_of(box);
    if (!reach) return {};

    Candidate candidate{.truth = {}, .reach = *reach};
    ObjectTruth& truth = candidate.truth;
    truth.id = instance.info->id;
    truth.name = instance.info->name;
    truth.object_class = instance.info->object_class;
    truth.class_number = instance.info->class_number;
    truth.box_full_min = box.min;
    truth.box_full_max = box.max;
    truth.is_clipped = box.is_clipped;
    truth.truncated = truncation_of(box);
    truth.position = instance.position;
    truth.orientation = object_.orientation();
    truth.velocity = instance.velocity;
    truth.dimensions = object_.max() - object_.min();
    truth.center = object_.position() + object_.orientation() * (0.5 * (object_.min() + object_.max()));
    truth.keypoints = keypoints_of(instance);
    candidates_.push_back(std::move(candidate));
    return {};
}

/// Pixels of the picture within box_margin_px of the box; none if there are none. What is clipped has no exact box.
std::optional<PixelBox> TruthMaker::reach_of(const ProjectedBox& box) const {
    const ImageSize size = camera_.size();
    if (box.is_empty()) return std::nullopt;
    if (box.is_clipped) return PixelBox{0, 0, size.width, size.height};
    const auto low = [](double edge, int end) {
        return static_cast<int>(std::clamp(std::floor(edge) - box_margin_px, 0.0, static_cast<double>(end)));
    };
    const auto high = [](double edge, int end) {
        return static_cast<int>(std::clamp(std::ceil(edge) + box_margin_px + 1, 0.0, static_cast<double>(end)));
    };
    const int left = low(box.min.x, size.width), right = high(box.max.x, size.width);
    const int top = low(box.min.y, size.height), bottom = high(box.max.y, size.height);
    if (left >= right || top >= bottom) return std::nullopt;
    return PixelBox{left, top, right - left, bottom - top};
}

double TruthMaker::truncation_of(const ProjectedBox& box) const {
    const glm::dvec2 low(-0.5), high(camera_.size().width - 0.5, camera_.size().height - 0.5);
    const glm::dvec2 whole = box.max - box.min;
    const glm::dvec2 inside = glm::max(glm::dvec2(0.0), glm::min(box.max, high) - glm::max(box.min, low));
    const double area = whole.x * whole.y;
    return area > 0.0 ? std::clamp(1.0 - inside.x * inside.y / area, 0.0, 1.0) : 0.0;
}

std::vector<Keypoint> TruthMaker::keypoints_of(const world::Instance& instance) {
    const world::Model& model = *instance.info->model;
    std::vector<Keypoint> points;
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
        if (model.nodes[i].keypoint.empty()) continue;
        const auto named = std::ranges::find(coco_keypoints, model.nodes[i].keypoint);
        if (named == coco_keypoints.end()) continue;
        points.resize(coco_keypoints.size());
        const auto index = static_cast<std::size_t>(named - coco_keypoints.begin());
        Keypoint& point = points[index];
        point.is_known = true;
        point.world = object_.position() + object_.orientation() * object_.place_of_node(i);
        const glm::dvec3 seen =
            rolling_ ? rolling_->see(world_of(first_, first_.place_of_node(i)), world_of(last_, last_.place_of_node(i)))
                     : optical(point.world);
        const auto pixel = camera_.project(seen);
        point.has_pixel = pixel.has_value();
        if (!pixel) continue;
        point.pixel = *pixel;
        point.visibility = visibility_of(point, seen, keypoint_tolerance_m(index) * instance.scale, instance.info->id);
    }
    return points;
}

KeypointVisibility TruthMaker::visibility_of(const Keypoint& point, const glm::dvec3& seen, double tolerance_m,
                                             ObjectId id) const {
    if (!camera_.in_image(point.pixel)) return KeypointVisibility::outside;
    const ImageSize size = camera_.size();
    // Not lround: it takes -0.5, which is in the picture, to -1.
    const int x = std::min(static_cast<int>(std::floor(point.pixel.x + 0.5)), size.width - 1);
    const int y = std::min(static_cast<int>(std::floor(point.pixel.y + 0.5)), size.height - 1);
    const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(x);
    const bool is_own = ids_of(*pictures_.instance)[i] == static_cast<std::uint32_t>(id);
    double point_m = seen.z, shown_m = depths_of(*pictures_.depth)[i];
    // Depth is along the axis: beside a camera that sees so far it says little of what is nearer, and behind it the
    // opposite.
    if (sees_behind(camera_.lens().lens().model) && std::isfinite(shown_m)) {
        const auto ray = camera_.ray({x, y});
        const bool is_told = ray && std::abs(ray->z) > 1e-6 * glm::length(*ray);
        point_m = glm::length(seen);
        shown_m = is_told ? shown_m / ray->z * glm::length(*ray) : point_m;
    }
    const double hides_m = point_m - (is_own ? tolerance_m : 0.0);
    return shown_m >= hides_m ? KeypointVisibility::visible : KeypointVisibility::occluded;
}

void TruthMaker::account(ObjectTruth& truth, const frame::Silhouette& alone) const {
    const auto id = static_cast<std::uint32_t>(truth.id);
    for (const frame::PixelRun& run : alone) truth.pixels_alone += run.x1 - run.x0;
    if (const auto seen = counts_.find(id); seen != counts_.end()) {
        truth.pixels = seen->second.pixels;
        truth.box = seen->second.box;
    }
    if (const auto under = soiled_.find(id); under != soiled_.end()) truth.pixels_soiled = under->second;
    if (truth.pixels == truth.pixels_alone) return;
    const auto occluder = main_occluder(ids_of(*pictures_.instance), alone, id, view_.spec->size);
    if (occluder != 0) truth.occluded_by = ObjectId{occluder};
}

Result<std::vector<ObjectTruth>> TruthMaker::finish(const FindSilhouettes& find_silhouettes) {
    std::vector<ObjectId> ids;
    std::vector<PixelBox> reaches;
    for (const Candidate& candidate : candidates_) {
        ids.push_back(candidate.truth.id);
        reaches.push_back(candidate.reach);
    }
    const auto silhouettes = find_silhouettes(ids, reaches);
    if (!silhouettes) return std::unexpected(silhouettes.error());
    CHECK(silhouettes->size() == candidates_.size());
    std::vector<ObjectTruth> objects;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
        account(candidates_[i].truth, (*silhouettes)[i]);
        if (candidates_[i].truth.pixels_alone > 0) objects.push_back(std::move(candidates_[i].truth));
    }
    std::ranges::sort(objects, {}, &ObjectTruth::id);
    return objects;
}

Result<TruthOfFrame> make_truth(const TruthView& view, const world::Snapshot& snapshot, const TruthPictures& pictures,
                                const FindSilhouettes& find_silhouettes, StandingObjects* standing) {
    const world::CameraSpec& spec = *view.spec;
    const auto camera = camera::CameraModel::create(spec.size, spec.intrinsics, spec.lens);
    if (!camera) return std::unexpected(camera.error());
    TruthOfFrame truth;
    truth.camera = *view.name;
    truth.sequence = view.sequence;
    truth.world_ns = snapshot.world_ns;
    truth.monotonic_ns = view.monotonic_ns;
    truth.clock = view.clock;
    truth.sensor = view.sensor;
    truth.spec = view.spec;
    truth.size = spec.size;
    truth.intrinsics = spec.intrinsics;
    truth.lens = spec.lens;
    truth.pose = view.pose;
    truth.believed_pose = view.believed_pose;
    truth.head = view.head;
    truth.faults = view.faults;
    if (view.film) truth.film = {view.film->frame, view.film->late};

    TruthMaker maker(view, *camera, pictures);
    for (const auto* instances : {&snapshot.statics->objects, &snapshot.movers}) {
        for (const world::Instance& instance : *instances)
            truth.classes[instance.info->class_number] = instance.info->object_class;
    }
    // What stands still was measured of an eye that stood.
    if (auto measured = maker.measure(snapshot, view.rows ? nullptr : standing); !measured)
        return std::unexpected(measured.error());
    auto objects = maker.finish(find_silhouettes);
    if (!objects) return std::unexpected(objects.error());
    truth.objects = std::move(*objects);
    return truth;
}

}  // namespace camrig::truth
