#include "tools/camrig/camera_controls.h"

#include <algorithm>
#include <iterator>

#include "tools/camrig/error_controls.h"
#include "v4l2_sink/preload/device_output.h"

namespace camrig::cli {
namespace {

constexpr const char* not_told = "the camera's state has not been told yet";

bool has_error_controls(const KnownCamera& known) {
    return std::ranges::any_of(known.camera.spec()->outputs, [](const OutputSpec& output) {
        return output.kind == "device" && options_of<device::DeviceOutput>(output).error_controls;
    });
}

}  // namespace

void CameraControls::on_change(Changed changed) {
    std::lock_guard lock(mutex_);
    changed_ = std::move(changed);
}

std::vector<device::DeviceControl> CameraControls::list(std::string_view camera) {
    const auto found = known(camera);
    const KnownCamera* const camera_known = found ? &*found : nullptr;
    std::vector<device::DeviceControl> controls;
    for (const CameraControl& one : camera_controls())
        if (has_control(one, camera_known)) controls.push_back(listed_for(one, camera_known));
    if (found && has_error_controls(*found)) std::ranges::move(error_controls(), std::back_inserter(controls));
    return controls;
}

std::optional<KnownCamera> CameraControls::known(std::string_view camera) const {
    std::lock_guard lock(mutex_);
    const auto found = known_.find(camera);
    return found == known_.end() ? std::nullopt : std::optional(found->second);
}

Result<std::int32_t> CameraControls::get(std::string_view camera, std::uint32_t id) {
    const CameraControl* const control = find_control(id);
    if (!control) return error(ErrorKind::not_found, "no such control");
    const auto found = known(camera);
    if (!found) return error(ErrorKind::unavailable, not_told);
    const device::DeviceControl listed = listed_for(*control, &*found);
    return std::clamp(read_control(*control, *found), listed.minimum, listed.maximum);
}

void CameraControls::ask(std::string_view camera, std::uint32_t id, std::function<void(Result<std::int32_t>)> done) {
    // Faults come and go by other commands, and by themselves.
    if (is_error_control(id))
        return commands_.post(engine::Request<engine::GetCamera>{
            {std::string(camera)}, [id, done = std::move(done)](const Result<engine::CameraReply>& report) {
                if (!report) return done(std::unexpected(report.error()));
                done(error_value(id, report->camera.faults().present(report->now.world_ns)));
            }});
    const CameraControl* const control = find_control(id);
    const auto found = known(camera);
    if (!control || !control->at || !found || !head_of(*found)) return done(get(camera, id));
    commands_.post(engine::Request<engine::GetPtz>{{std::string(camera)},
                                                   [control, listed = listed_for(*control, &*found),
                                                    done = std::move(done)](const Result<engine::PtzReply>& reply) {
                                                       if (!reply) return done(std::unexpected(reply.error()));
                                                       done(std::clamp(control->at(reply->status.position),
                                                                       listed.minimum, listed.maximum));
                                                   }});
}

void CameraControls::set(std::string_view camera, std::span<const device::DeviceControlValue> values,
                         std::function<void(Result<void>)> done) {
    const auto before = known(camera);
    if (!before) return done(error(ErrorKind::unavailable, not_told));
    if (std::ranges::any_of(values, is_error_control, &device::DeviceControlValue::id))
        return set_errors(std::string(camera), values, std::move(done));
    ControlChange change{.manual = before->manual, .patch = {}, .turn = {}, .drive = {}};
    for (const auto& [id, value] : values) {
        const CameraControl* const control = find_control(id);
        if (!control) return done(error(ErrorKind::not_found, "no such control"));
        control->write(value, *before, change);
    }
    const std::string name(camera);
    std::vector<std::uint32_t> ids;
    for (const auto& [id, value] : values) ids.push_back(id);
    {
        std::lock_guard lock(mutex_);
        being_set_[name].insert(ids.begin(), ids.end());
        if (const auto there = known_.find(name); there != known_.end()) there->second.manual = change.manual;
    }
    // They go into the engine's queue one after the other; the last one's answer is the state after all of them.
    auto first_error = std::make_shared<std::optional<Error>>();
    for (auto* move : {&change.turn, &change.drive}) {
        if (!*move) continue;
        commands_.post(engine::Request<engine::MovePtz>{{name, **move}, [first_error](const auto& report) {
                                                            if (!report && !*first_error) *first_error = report.error();
                                                        }});
    }
    const auto finish = [self = weak_from_this(), name, ids, first_error,
                         done = std::move(done)](const Result<engine::CameraReply>& report) {
        const auto alive = self.lock();
        if (alive && report) alive->told(*report);
        if (alive) {
            std::lock_guard lock(alive->mutex_);
            auto& set = alive->being_set_[name];
            for (const std::uint32_t id : ids) set.erase(set.find(id));
            if (set.empty()) alive->being_set_.erase(name);
        }
        if (*first_error) return done(std::unexpected(**first_error));
        if (!report) return done(std::unexpected(report.error()));
        done({});
    };
    if (change.patch)
        commands_.post(engine::Request<engine::SetCamera>{{.name = name, .patch = std::move(*change.patch)}, finish});
    else
        commands_.post(engine::Request<engine::GetCamera>{{name}, finish});
}

void CameraControls::set_errors(const std::string& camera, std::span<const device::DeviceControlValue> values,
                                std::function<void(Result<void>)> done) {
    std::vector<ErrorSetting> settings;
    for (const auto& [id, value] : values) {
        if (!is_error_control(id)) return done(error(ErrorKind::invalid_argument, "give these controls alone"));
        settings.push_back(error_setting(id, value));
    }
    // A button's fault has an end, which is told in world time.
    commands_.post(engine::Request<engine::GetCamera>{
        {camera}, [self = weak_from_this(), camera, settings, done = std::move(done)](const auto& report) {
            const auto alive = self.lock();
            if (!report) return done(std::unexpected(report.error()));
            if (!alive) return done(error(ErrorKind::unavailable, "the rig ends"));
            auto last = std::make_shared<std::optional<Error>>();
            for (const ErrorSetting& setting : settings) {
                if (!setting.clears.empty())
                    alive->commands_.post(engine::Request<engine::ClearFaults>{
                        {.id = std::nullopt, .camera = camera, .kind = std::string(setting.clears)},
                        [](const auto&) {}});
                if (!setting.fault) continue;
                fault::FaultSpec fault = *setting.fault;
                if (setting.is_button) fault.end_ns = report->now.world_ns + pressed_ns;
                alive->commands_.post(
                    engine::Request<engine::SetFault>{{camera, std::move(fault)}, [last](const auto& set) {
                                                          if (!set) *last = set.error();
                                                      }});
            }
            alive->commands_.post(engine::Request<engine::GetCamera>{
                {camera}, [last, done](const auto&) { *last ? done(std::unexpected(**last)) : done({}); }});
        }});
}

void CameraControls::refresh(const std::string& camera) {
    commands_.post(engine::Request<engine::GetCamera>{
        {camera}, [self = weak_from_this()](const Result<engine::CameraReply>& report) {
            const auto alive = self.lock();
            if (alive && report) alive->told(*report);
        }});
}

void CameraControls::forget(const std::string& camera) {
    std::lock_guard lock(mutex_);
    known_.erase(camera);
}

void CameraControls::told(const engine::CameraReply& report) {
    std::lock_guard lock(mutex_);
    const std::string& name = report.camera.spec()->name;
    KnownCamera now{report.camera, report.now.head};
    const auto before = known_.find(name);
    if (before != known_.end()) now.manual = before->second.manual;
    if (const auto* sensor = sensor_of(now)) {
        now.manual.exposure_s = sensor->exposure_s.value_or(now.manual.exposure_s);
        now.manual.white_balance_k = sensor->white_balance_k.value_or(now.manual.white_balance_k);
    }
    const auto setting = being_set_.find(name);
    std::vector<std::uint32_t> ids;
    if (before != known_.end())
        for (const CameraControl& one : camera_controls())
            if (read_control(one, before->second) != read_control(one, now) &&
                (setting == being_set_.end() || !setting->second.contains(one.control.id)))
                ids.push_back(one.control.id);
    known_.insert_or_assign(name, now);
    if (!ids.empty() && changed_) changed_(name, ids);
}

}  // namespace camrig::cli
