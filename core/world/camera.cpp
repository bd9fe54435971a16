#include "core/world/camera.h"

#include "core/camera/lens_map.h"
#include "core/camera/ptz_axes.h"
#include "core/fault/body.h"
#include "core/world/mount.h"
#include "core/world/step_history.h"

namespace camrig::world {

static_assert(camera::Timeline<camera::Pose>::kept_ns >= StepHistory::span_ns);

Camera::Camera(CameraSpec spec)
    : spec_(std::make_shared<const CameraSpec>(std::move(spec))),
      place_({spec_->mount, spec_->pose}),
      intrinsics_(spec_->intrinsics),
      clock_(spec_->clock) {
    if (spec_->ptz) head_.emplace(*spec_->ptz);
}

TimeNs Camera::arrives_ns() const {
    const TimeNs alone_ns = std::max(place_.arrives_ns(), intrinsics_.arrives_ns());
    return head_ ? std::max(alone_ns, head_->arrives_ns()) : alone_ns;
}

Result<Camera> Camera::changed(const CameraPatch& patch, TimeNs begin_ns, TimeNs duration_ns) const {
    const bool turns = patch.pan_rad || patch.tilt_rad;
    CameraSpec base = *spec_;
    if (turns) base.pose = place_.at(begin_ns).pose;
    auto spec = patch_camera_spec(base, patch);
    if (!spec) return std::unexpected(spec.error());

    // Before a panorama it may turn and zoom, before a projected picture also move.
    const bool stands = spec->backdrop && !spec->backdrop->is_projected() &&
                        !(spec->backdrop->is_panorama() && spec->pose.position == base.pose.position);
    if (stands && duration_ns > 0 && (patch.pose || turns || patch.optics || patch.zoom))
        return error(ErrorKind::unsupported,
                     "seconds: a camera with a backdrop stands still, because its picture is true from one place only; "
                     "what changes its pose or optics is at once");

    Camera next = *this;
    next.spec_ = std::make_shared<const CameraSpec>(std::move(*spec));
    const CameraSpec &before = *spec_, &after = *next.spec_;
    const bool is_mounted_anew = after.mount != before.mount;
    if (is_mounted_anew || patch.pose || turns)
        next.place_.go_to({after.mount, after.pose}, begin_ns, is_mounted_anew ? 0 : duration_ns);
    if (after.ptz != before.ptz) {
        next.head_before_ = head_;
        next.head_since_ns_ = begin_ns;
        next.head_ = after.ptz ? std::optional<camera::PtzHead>(*after.ptz) : std::nullopt;
    }
    if (after.clock != before.clock) next.clock_.set(after.clock, begin_ns);
    const camera::Intrinsics &from = before.intrinsics, &to = after.intrinsics;
    if ((patch.optics || patch.zoom) && after.size == before.size)
        next.intrinsics_.go_to(to, begin_ns, from.cx == to.cx && from.cy == to.cy ? duration_ns : 0);
    else if (from != to)
        next.intrinsics_ = camera::Timeline(to);
    return next;
}

Result<const camera::PtzHead*> Camera::head() const {
    if (head_) return &*head_;
    return error(ErrorKind::unsupported, "camera " + spec_->name +
                                             " has no head; give it one, as by camrig camera set " + spec_->name +
                                             " --ptz preset=dome");
}

Result<Camera> Camera::with_head(const std::function<Result<void>(camera::PtzHead&)>& tell) const {
    if (auto there = head(); !there) return std::unexpected(there.error());
    Camera next = *this;
    if (auto told = tell(*next.head_); !told) return std::unexpected(told.error());
    return next;
}

Result<camera::PtzMove> Camera::in_angles(camera::PtzMove move, TimeNs world_ns) const {
    if (move.mode == camera::PtzMode::fov) {
        if (!move.x && !move.y) return move;
        const auto there = angles_at(move.x.value_or(0.0), move.y.value_or(0.0), world_ns);
        if (!there) return std::unexpected(there.error());
        move.pan_deg = there->pan_deg;
        move.tilt_deg = there->tilt_deg;
        return move;
    }
    if (!head_ || !head_->spec().flips || !move.tilt_deg || move.mode == camera::PtzMode::absolute) return move;
    if (is_over(place_.at(world_ns).pose, head_->status(world_ns).position)) move.tilt_deg = -*move.tilt_deg;
    return move;
}

Result<camera::PtzPosition> Camera::angles_at(double x, double y, TimeNs world_ns) const {
    const auto head = this->head();
    if (!head) return std::unexpected(head.error());
    const auto lens = camera::LensMap::create(spec_->lens);
    if (!lens) return std::unexpected(lens.error());
    const camera::PtzPosition now = (*head)->status(world_ns).position;
    const camera::Intrinsics k = intrinsics_.at(world_ns);
    const auto [width, height] = spec_->size;
    const glm::dvec2 pixel(0.5 * (width - 1 + x * width), 0.5 * (height - 1 - y * height));
    const auto ideal = lens->undistort({(pixel.x - k.cx) / (k.fx * now.zoom), (pixel.y - k.cy) / (k.fy * now.zoom)});
    if (!ideal) return error(ErrorKind::invalid_argument, "x: the lens shows nothing there");
    const glm::dvec3 seen = camera::link_from_optical() * lens->direction_from_ideal(*ideal);
    const camera::Pose base = place_.at(world_ns).pose;
    const bool over = (*head)->spec().flips && is_over(base, now);
    return aimed_along(base, turned_by(base, now, over).orientation * seen, now);
}

Camera Camera::in_another_world(const Snapshot& last) const {
    Camera camera(*spec_);
    if (head_) camera.head_ = head_->standing(last.world_ns);
    if (spec_->mount) camera.left_ = camera::Timeline(frame_in(last, *spec_->mount));
    return camera;
}

void Camera::leave(const Instance& carrier, TimeNs world_ns) {
    left_.go_to(mount_frame(carrier, spec_->mount->node), world_ns, 0);
}

Camera::Place between(const Camera::Place& a, const Camera::Place& b, double share) {
    return {b.mount, between(a.pose, b.pose, share)};
}

camera::Pose Camera::frame_in(const Snapshot& world, const Mount& mount) const {
    for (const std::vector<Instance>* movers : {&world.movers, &world.hidden}) {
        const auto carrier =
            std::ranges::find_if(*movers, [&](const Instance& mover) { return mover.info->name == mount.actor; });
        if (carrier != movers->end()) return mount_frame(*carrier, mount.node);
    }
    return left_.at(world.world_ns);
}

std::optional<ClockReading> Camera::clock_at(TimeNs world_ns) const {
    return clock_.at(world_ns, exposure_times_of(*spec_).least_apart_ns());
}

camera::Pose Camera::base_at(const Snapshot& world) const {
    const Place place = place_.at(world.world_ns);
    return place.mount ? in_world(frame_in(world, *place.mount), place.pose) : place.pose;
}

camera::CameraState Camera::at(const Snapshot& world) const {
    const Place place = place_.at(world.world_ns);
    camera::CameraState state{.world_ns = world.world_ns,
                              .pose = place.pose,
                              .believed_pose = {},
                              .intrinsics = intrinsics_.at(world.world_ns),
                              .head = {},
                              .clock = clock_at(world.world_ns)};
    if (const auto& head = world.world_ns < head_since_ns_ ? head_before_ : head_) {
        state.head = head->status(world.world_ns);
        const camera::PtzPosition& turned = state.head->true_position;
        // By the angles that it believes in, as its commands: what it is off would turn a picture that looks straight
        // down over and over.
        const bool over = head->spec().flips && is_over(state.pose, state.head->position);
        state.pose = turned_by(state.pose, turned, over);
        state.intrinsics.fx *= turned.zoom;
        state.intrinsics.fy *= turned.zoom;
    }
    if (place.mount) state.pose = in_world(frame_in(world, *place.mount), state.pose);
    if (const auto faults = faults_.at({0, world.world_ns}); faults && moves_body(*faults)) {
        state.believed_pose = state.pose;
        state.pose = moved(*faults, state.pose);
    }
    return state;
}

CameraSpec Camera::spec_at(TimeNs world_ns) const {
    CameraSpec spec = *spec_;
    const Place place = place_.at(world_ns);
    spec.mount = place.mount;
    spec.pose = place.pose;
    spec.intrinsics = intrinsics_.at(world_ns);
    return spec;
}

}  // namespace camrig::world
