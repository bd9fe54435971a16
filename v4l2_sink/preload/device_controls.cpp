#include "v4l2_sink/preload/device_controls.h"

#include <algorithm>
#include <cerrno>

#include <linux/videodev2.h>

namespace camrig::device {
namespace {

std::span<const camrig_control> controls_of(const camrig_description& description) {
    return {description.control, description.control_count};
}

std::uint32_t type_of(DeviceControl::Kind kind) {
    return kind == DeviceControl::Kind::menu      ? V4L2_CTRL_TYPE_MENU
           : kind == DeviceControl::Kind::boolean ? V4L2_CTRL_TYPE_BOOLEAN
           : kind == DeviceControl::Kind::button  ? V4L2_CTRL_TYPE_BUTTON
                                                  : V4L2_CTRL_TYPE_INTEGER;
}

}  // namespace

void DeviceControls::describe(const std::string& camera, camrig_description& description) {
    for (const DeviceControl& control : port_->list(camera)) {
        if (description.control_count == camrig_max_controls) break;
        camrig_control& out = description.control[description.control_count++];
        out.id = control.id;
        out.type = type_of(control.kind);
        out.flags = control.flags;
        out.minimum = control.minimum;
        out.maximum = control.maximum;
        out.step = control.step;
        out.default_value = control.default_value;
        copy_text(out.name, control.name);
        for (std::size_t i = 0; i < control.menu.size(); ++i) {
            const std::int64_t value = control.minimum + static_cast<std::int64_t>(i);
            if (!control.menu[i].empty() && value >= 0 && value < 32) out.menu_mask |= 1u << value;
        }
    }
}

Handled DeviceControls::get(const SessionRef& session, const std::string& camera, const camrig_request& request) {
    session->awaits_reply = true;
    port_->ask(camera, request.u.control_id,
               [tasks = tasks_, weak = std::weak_ptr(session), id = request.u.control_id,
                serial = request.serial](const Result<std::int32_t>& value) {
                   tasks->post([weak, id, serial, value] {
                       const SessionRef asker = weak.lock();
                       if (!asker) return;
                       asker->awaits_reply = false;
                       if (!value) return asker->fail(serial, errno_of(value.error()));
                       camrig_reply reply{};
                       reply.u.controls.count = 1;
                       reply.u.controls.values[0] = {id, *value};
                       asker->reply(serial, reply);
                   });
               });
    return answered;
}

Handled DeviceControls::set(const SessionRef& session, const std::string& camera, const camrig_request& request) {
    const camrig_controls_set& requested = request.u.controls;
    if (requested.count == 0 || requested.count > camrig_max_controls) return EINVAL;
    std::vector<DeviceControlValue> values;
    for (std::uint32_t i = 0; i < requested.count; ++i) {
        const auto controls = controls_of(session->description);
        const auto known = std::ranges::find(controls, requested.values[i].id, &camrig_control::id);
        if (known == controls.end()) return EINVAL;
        if (requested.values[i].value < known->minimum || requested.values[i].value > known->maximum) return ERANGE;
        values.push_back({requested.values[i].id, requested.values[i].value});
    }
    session->awaits_reply = true;
    port_->set(camera, values,
               [this, tasks = tasks_, weak = std::weak_ptr(session), camera, values,
                serial = request.serial](const Result<void>& done) {
                   tasks->post([this, weak, camera, values, serial, done] {
                       const SessionRef asker = weak.lock();
                       if (!asker) return;
                       asker->awaits_reply = false;
                       if (done) {
                           for (const auto& [id, value] : values) tell(asker.get(), camera, id, value);
                           asker->reply(serial, camrig_reply{});
                       } else {
                           asker->fail(serial, errno_of(done.error()));
                       }
                   });
               });
    return answered;
}

Handled DeviceControls::menu(DeviceSession& session, const std::string& camera, const camrig_request& request) {
    for (const DeviceControl& control : port_->list(camera)) {
        if (control.id != request.u.menu.id || control.kind != DeviceControl::Kind::menu) continue;
        const std::int64_t entry = std::int64_t{request.u.menu.index} - control.minimum;
        if (entry < 0 || entry >= std::ssize(control.menu) || control.menu[static_cast<std::size_t>(entry)].empty())
            return EINVAL;
        camrig_reply reply{};
        copy_text(reply.u.menu_name, control.menu[static_cast<std::size_t>(entry)]);
        session.reply(request.serial, reply);
        return answered;
    }
    return EINVAL;
}

Handled DeviceControls::subscribe(DeviceSession& session, const camrig_request& request) {
    const camrig_subscribe& requested = request.u.subscribe;
    const auto controls = controls_of(session.description);
    if (std::ranges::find(controls, requested.id, &camrig_control::id) == controls.end()) return EINVAL;
    if (requested.on != 0)
        session.subscriptions[requested.id] = requested.feedback != 0;
    else
        session.subscriptions.erase(requested.id);
    return 0;
}

void DeviceControls::changed(const std::string& camera, std::uint32_t id) {
    if (const auto value = port_->get(camera, id)) tell(nullptr, camera, id, *value);
}

void DeviceControls::tell(const DeviceSession* by, const std::string& camera, std::uint32_t id, std::int32_t value) {
    for (const SessionRef& session : openers_(camera)) {
        const auto subscription = session->subscriptions.find(id);
        if (subscription == session->subscriptions.end()) continue;
        if (session.get() == by && !subscription->second) continue;
        const camrig_control_event event{camrig_message_control_event, id, value, 0};
        session->tell(event);
    }
}

}  // namespace camrig::device
