
#include <cerrno>
#include <initializer_list>

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <string.h>

#include "v4l2_sink/preload/client/device.h"
#include "v4l2_sink/preload/client/sys.h"

namespace camrig::device {

namespace {

constexpr uint32_t class_mask = 0x0fff0000;
constexpr uint32_t vivid_class = 0x00f00000;  // drivers/media/test-drivers/vivid/vivid-ctrls.c
constexpr uint32_t id_mask = 0x0fffffff;      // without V4L2_CTRL_FLAG_NEXT_*
constexpr uint32_t next_flags = V4L2_CTRL_FLAG_NEXT_CTRL | V4L2_CTRL_FLAG_NEXT_COMPOUND;
constexpr uint32_t max_ext_controls = 1024;  // V4L2_CID_MAX_CTRLS

bool is_class(uint32_t id) {
    return (id & 0xffff) == 1;
}
uint32_t class_id(uint32_t id) {
    return (id & class_mask) | 1;
}

const camrig_control* find(const Device& device, uint32_t id) {
    for (uint32_t i = 0; i < device.description.control_count; ++i)
        if (device.description.control[i].id == id) return &device.description.control[i];
    return nullptr;
}

bool has_class(const Device& device, uint32_t id) {
    if (!is_class(id)) return false;
    for (uint32_t i = 0; i < device.description.control_count; ++i)
        if (class_id(device.description.control[i].id) == id) return true;
    return false;
}

const char* class_name(uint32_t id) {
    if ((id & class_mask) == vivid_class) return "Vivid Controls";
    return (id & class_mask) == V4L2_CTRL_CLASS_CAMERA ? "Camera Controls" : "User Controls";
}

/// The smallest id above `id` among controls and their classes; 0 when there is none.
uint32_t next_id(const Device& device, uint32_t id) {
    uint32_t best = 0;
    for (uint32_t i = 0; i < device.description.control_count; ++i) {
        const uint32_t own = device.description.control[i].id;
        for (const uint32_t candidate : {class_id(own), own})
            if (candidate > id && (best == 0 || candidate < best)) best = candidate;
    }
    return best;
}

int read_value(Device& device, uint32_t id, int32_t& value) {
    camrig_request request{};
    request.type = camrig_request_get_control;
    request.u.control_id = id;
    camrig_reply reply;
    if (const int problem = transact(device, request, reply, nullptr)) return problem;
    value = reply.u.controls.values[0].value;
    return 0;
}

/// Brings a value into the control's range as the kernel's control framework does.
int fit(const camrig_control& control, int32_t& value) {
    if (control.type == V4L2_CTRL_TYPE_BUTTON) {
        value = 0;  // of any value, as the kernel has it
        return 0;
    }
    if (control.type == V4L2_CTRL_TYPE_BOOLEAN) {
        value = value != 0;
        return 0;
    }
    if (control.type == V4L2_CTRL_TYPE_MENU)
        return value < control.minimum || value > control.maximum                  ? ERANGE
               : value < 0 || value > 31 || (control.menu_mask >> value & 1u) == 0 ? EINVAL
                                                                                   : 0;
    if (value < control.minimum) value = control.minimum;
    if (value > control.maximum) value = control.maximum;
    if (control.step > 1) {
        const int64_t steps = (int64_t{value} - control.minimum + control.step / 2) / control.step;
        int64_t fitted = control.minimum + steps * control.step;
        if (fitted > control.maximum) fitted -= control.step;
        value = static_cast<int32_t>(fitted);
    }
    return 0;
}

const camrig_control* writable(const Device& device, uint32_t id, int& problem) {
    const camrig_control* control = find(device, id);
    problem = 0;
    if (control == nullptr)
        problem = has_class(device, id) ? EACCES : EINVAL;
    else if ((control->flags & V4L2_CTRL_FLAG_READ_ONLY) != 0)
        problem = EACCES;
    return problem == 0 ? control : nullptr;
}

int send_values(Device& device, const camrig_controls_set& values, uint32_t& refused) {
    camrig_request request{};
    request.type = camrig_request_set_controls;
    request.u.controls = values;
    camrig_reply reply;
    const int problem = transact(device, request, reply, nullptr);
    if (problem != 0 && problem != ENODEV) refused = reply.detail;
    return problem;
}

/// Where the values of an extended-control call come from.
bool wants_defaults(const v4l2_ext_controls& controls) {
    return controls.which == V4L2_CTRL_WHICH_DEF_VAL;
}

int check_list(Device& device, v4l2_ext_controls& controls, bool writes) {
    if (controls.which == V4L2_CTRL_WHICH_REQUEST_VAL) return EINVAL;
    if (controls.count == 0)
        return wants_defaults(controls) || controls.which == 0 || has_class(device, controls.which | 1) ? 0 : EINVAL;
    if (controls.count > max_ext_controls) return ENOMEM;
    if (controls.controls == nullptr) return EFAULT;
    for (uint32_t i = 0; i < controls.count; ++i) {
        v4l2_ext_control& entry = controls.controls[i];
        if (!writes)
            controls.error_idx = controls.count;
        else
            controls.error_idx = i;
        if (controls.which != 0 && !wants_defaults(controls) &&
            (entry.id & class_mask) != (controls.which & class_mask))
            return EINVAL;
        const camrig_control* control = find(device, entry.id);
        if (control == nullptr && !has_class(device, entry.id)) return EINVAL;
        if (control == nullptr) return EACCES;
        if (writes && (control->flags & V4L2_CTRL_FLAG_READ_ONLY) != 0) return EACCES;
        if (!writes && (control->flags & V4L2_CTRL_FLAG_WRITE_ONLY) != 0) return EACCES;
    }
    return 0;
}

int read_list(Device& device, v4l2_ext_controls& controls) {
    for (uint32_t i = 0; i < controls.count; ++i) {
        v4l2_ext_control& entry = controls.controls[i];
        if (wants_defaults(controls)) {
            entry.value = find(device, entry.id)->default_value;
            continue;
        }
        int32_t value = 0;
        if (const int problem = read_value(device, entry.id, value)) {
            controls.error_idx = i;
            return problem;
        }
        entry.value = value;
    }
    return 0;
}

int write_list(Device& device, v4l2_ext_controls& controls, bool really) {
    if (wants_defaults(controls)) return EINVAL;
    camrig_controls_set values{};
    for (uint32_t i = 0; i < controls.count; ++i) {
        v4l2_ext_control& entry = controls.controls[i];
        controls.error_idx = i;
        int32_t value = entry.value;
        if (const int problem = fit(*find(device, entry.id), value)) return problem;
        if (!really) {
            entry.value = value;
            continue;
        }
        if (values.count >= camrig_max_controls) return ENOSPC;
        values.values[values.count++] = {entry.id, value};
    }
    if (!really || values.count == 0) return 0;
    uint32_t refused = 0;
    const int problem = send_values(device, values, refused);
    controls.error_idx = refused;
    for (uint32_t i = 0; problem == 0 && i < controls.count; ++i) controls.controls[i].value = values.values[i].value;
    return problem;
}

Subscription* subscription_of(Device& device, uint32_t type, uint32_t id) {
    for (Subscription& entry : device.subscriptions)
        if (entry.type == type && entry.id == id) return &entry;
    return nullptr;
}

int tell_subscription(Device& device, uint32_t id, bool on, bool feedback) {
    camrig_request request{};
    request.type = camrig_request_subscribe;
    request.u.subscribe = {id, on ? 1u : 0u, feedback ? 1u : 0u};
    camrig_reply reply;
    return transact(device, request, reply, nullptr);
}

void drop_event(Device& device, uint32_t position) {
    for (uint32_t i = position; i + 1 < device.event_count; ++i)
        device.events[(device.event_first + i) % max_pending_events] =
            device.events[(device.event_first + i + 1) % max_pending_events];
    --device.event_count;
}

}  // namespace

int query_control(Device& device, v4l2_query_ext_ctrl& query) {
    uint32_t id = query.id & id_mask;
    if ((query.id & next_flags) != 0) {
        if ((query.id & V4L2_CTRL_FLAG_NEXT_CTRL) == 0) return EINVAL;  // there are no compound controls
        id = next_id(device, id);
    }
    const camrig_control* control = find(device, id);
    if (control == nullptr && !has_class(device, id)) return EINVAL;
    memset(&query, 0, sizeof query);
    query.id = id;
    if (control == nullptr) {
        query.type = V4L2_CTRL_TYPE_CTRL_CLASS;
        query.flags = V4L2_CTRL_FLAG_READ_ONLY | V4L2_CTRL_FLAG_WRITE_ONLY;
        strncpy(query.name, class_name(id), sizeof query.name - 1);
        return 0;
    }
    query.type = control->type;
    memcpy(query.name, control->name, sizeof query.name);
    query.minimum = control->minimum;
    query.maximum = control->maximum;
    query.step = static_cast<uint64_t>(control->step);
    query.default_value = control->default_value;
    query.flags = control->flags;
    query.elem_size = 4;
    query.elems = 1;
    return 0;
}

int query_menu(Device& device, v4l2_querymenu& menu) {
    const uint32_t id = menu.id, index = menu.index;
    const camrig_control* control = find(device, id);
    if (control == nullptr || control->type != V4L2_CTRL_TYPE_MENU || index < static_cast<uint32_t>(control->minimum) ||
        index > static_cast<uint32_t>(control->maximum))
        return EINVAL;
    camrig_request request{};
    request.type = camrig_request_menu;
    request.u.menu = {id, index};
    camrig_reply reply;
    if (const int problem = transact(device, request, reply, nullptr)) return problem;
    memset(&menu, 0, sizeof menu);
    menu.id = id;
    menu.index = index;
    memcpy(menu.name, reply.u.menu_name, sizeof menu.name - 1);
    return 0;
}

int get_control(Device& device, v4l2_control& control) {
    const camrig_control* known = find(device, control.id);
    if (known == nullptr) return has_class(device, control.id) ? EACCES : EINVAL;
    if ((known->flags & V4L2_CTRL_FLAG_WRITE_ONLY) != 0) return EACCES;
    int32_t value = 0;
    const int problem = read_value(device, control.id, value);
    if (problem == 0) control.value = value;
    return problem;
}

int set_control(Device& device, v4l2_control& control) {
    if (outranked(device)) return EBUSY;
    int problem = 0;
    const camrig_control* known = writable(device, control.id, problem);
    if (known == nullptr) return problem;
    int32_t value = control.value;
    if ((problem = fit(*known, value)) != 0) return problem;
    camrig_controls_set values{};
    values.count = 1;
    values.values[0] = {control.id, value};
    uint32_t refused = 0;
    if ((problem = send_values(device, values, refused)) != 0) return problem;
    control.value = value;
    return 0;
}

int ext_controls(Device& device, unsigned request, v4l2_ext_controls& controls) {
    const bool writes = request != VIDIOC_G_EXT_CTRLS;
    memset(controls.reserved, 0, sizeof controls.reserved);
    controls.error_idx = controls.count;
    if (request == VIDIOC_S_EXT_CTRLS && outranked(device)) return EBUSY;
    int problem = check_list(device, controls, writes);
    if (problem != 0) {
        // VIDIOC_TRY_* names the control at fault, the other two say "nothing was done" (count).
        if (request != VIDIOC_TRY_EXT_CTRLS) controls.error_idx = controls.count;
        return problem;
    }
    if (!writes) {
        problem = read_list(device, controls);
    } else {
        problem = write_list(device, controls, request == VIDIOC_S_EXT_CTRLS);
        if (problem != 0 && request == VIDIOC_S_EXT_CTRLS) controls.error_idx = controls.count;
    }
    if (problem == 0) controls.error_idx = controls.count;
    return problem;
}

void push_control_event(Device& device, uint32_t id, int32_t value, uint32_t changes, uint32_t flags) {
    const camrig_control* control = find(device, id);
    if (subscription_of(device, V4L2_EVENT_CTRL, id) == nullptr) return;
    // Per control only the newest value matters, as in the kernel's merge of control events.
    for (uint32_t i = 0; i < device.event_count; ++i) {
        const v4l2_event& old = device.events[(device.event_first + i) % max_pending_events];
        if (old.type != V4L2_EVENT_CTRL || old.id != id) continue;
        changes |= old.u.ctrl.changes;
        drop_event(device, i);
        break;
    }
    if (device.event_count == max_pending_events) drop_event(device, 0);
    v4l2_event& event = device.events[(device.event_first + device.event_count++) % max_pending_events];
    memset(&event, 0, sizeof event);
    event.type = V4L2_EVENT_CTRL;
    event.id = id;
    event.sequence = device.event_sequence++;
    raw_syscall(SYS_clock_gettime, CLOCK_MONOTONIC, arg(&event.timestamp));
    event.u.ctrl.changes = changes;
    if (control == nullptr) {  // a class
        event.u.ctrl.type = V4L2_CTRL_TYPE_CTRL_CLASS;
        event.u.ctrl.flags = V4L2_CTRL_FLAG_READ_ONLY | V4L2_CTRL_FLAG_WRITE_ONLY;
        return;
    }
    event.u.ctrl.type = control->type;
    event.u.ctrl.value = value;
    event.u.ctrl.flags = control->flags | flags;
    event.u.ctrl.minimum = control->minimum;
    event.u.ctrl.maximum = control->maximum;
    event.u.ctrl.step = control->step;
    event.u.ctrl.default_value = control->default_value;
}

int subscribe_event(Device& device, const v4l2_event_subscription& requested) {
    if (requested.type != V4L2_EVENT_CTRL) return EINVAL;  // a camera has no others
    const camrig_control* control = find(device, requested.id);
    if (control == nullptr && !has_class(device, requested.id)) return EINVAL;
    int32_t value = 0;
    if (control != nullptr) {
        const bool feedback = (requested.flags & V4L2_EVENT_SUB_FL_ALLOW_FEEDBACK) != 0;
        if (const int problem = tell_subscription(device, requested.id, true, feedback)) return problem;
        if ((control->flags & V4L2_CTRL_FLAG_WRITE_ONLY) == 0) read_value(device, requested.id, value);
    }
    Locked guard(device.control_lock);
    Subscription* entry = subscription_of(device, requested.type, requested.id);
    if (entry != nullptr) return 0;
    entry = subscription_of(device, 0, 0);
    if (entry == nullptr) return ENOMEM;
    *entry = {requested.type, requested.id, requested.flags};
    if (control != nullptr && (requested.flags & V4L2_EVENT_SUB_FL_SEND_INITIAL) != 0) {
        uint32_t changes = V4L2_EVENT_CTRL_CH_FLAGS;
        if ((control->flags & V4L2_CTRL_FLAG_WRITE_ONLY) == 0) changes |= V4L2_EVENT_CTRL_CH_VALUE;
        push_control_event(device, requested.id, value, changes, 0);
    }
    return 0;
}

int unsubscribe_event(Device& device, const v4l2_event_subscription& requested) {
    const bool all = requested.type == V4L2_EVENT_ALL;
    for (Subscription& entry : device.subscriptions) {
        if (entry.type == 0 || (!all && (entry.type != requested.type || entry.id != requested.id))) continue;
        if (find(device, entry.id) != nullptr) tell_subscription(device, entry.id, false, false);
        Locked guard(device.control_lock);
        for (uint32_t i = device.event_count; i > 0; --i)
            if (device.events[(device.event_first + i - 1) % max_pending_events].id == entry.id)
                drop_event(device, i - 1);
        entry = {};
    }
    return 0;
}

bool event_pending(Device& device) {
    collect_events(device);
    Locked guard(device.control_lock);
    return device.event_count > 0;
}

int dequeue_event(Device& device, int fd, v4l2_event& event) {
    for (;;) {
        collect_events(device);
        pollfd wait[2]{};
        {
            Locked guard(device.control_lock);
            if (device.event_count > 0) {
                event = device.events[device.event_first];
                device.event_first = (device.event_first + 1) % max_pending_events;
                event.pending = --device.event_count;
                return 0;
            }
            if (device.broken) return ENODEV;
            bool subscribed = false;
            for (const Subscription& entry : device.subscriptions) subscribed = subscribed || entry.type != 0;
            if ((sys_fcntl(fd, F_GETFL) & O_NONBLOCK) != 0 || !subscribed) return ENOENT;
            wait[0] = {device.control_fd, POLLIN, 0};
            wait[1] = {fd, 0, 0};
        }
        if (raw_syscall(SYS_ppoll, arg(wait), 2) == -EINTR) return EINTR;
        if ((wait[1].revents & (POLLHUP | POLLERR)) != 0) return ENODEV;
    }
}

}  // namespace camrig::device
