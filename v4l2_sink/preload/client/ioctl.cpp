
#include <cerrno>

#include <errno.h>
#include <poll.h>
#include <string.h>
#include <time.h>

#include "v4l2_sink/preload/client/device.h"
#include "v4l2_sink/preload/client/sys.h"

namespace camrig::device {

namespace {

constexpr uintptr_t lowest_address = 4096;

int enum_input(v4l2_input& input) {
    if (input.index != 0) return EINVAL;
    memset(&input, 0, sizeof input);
    strcpy(reinterpret_cast<char*>(input.name), "Camera 1");
    input.type = V4L2_INPUT_TYPE_CAMERA;
    return 0;
}

int set_priority(Device& device, uint32_t priority) {
    if (priority != V4L2_PRIORITY_BACKGROUND && priority != V4L2_PRIORITY_INTERACTIVE &&
        priority != V4L2_PRIORITY_RECORD)
        return EINVAL;
    if (outranked(device)) return EBUSY;
    camrig_request request{};
    request.type = camrig_request_priority;
    request.u.priority = priority;
    camrig_reply reply;
    const int problem = transact(device, request, reply, nullptr);
    if (problem == 0) device.priority = priority;
    return problem;
}

/// VIDIOC_QUERYCTRL in terms of its newer sibling.
int query_short(Device& device, v4l2_queryctrl& query) {
    v4l2_query_ext_ctrl full{};
    full.id = query.id;
    if (const int problem = query_control(device, full)) return problem;
    memset(&query, 0, sizeof query);
    query.id = full.id;
    query.type = full.type;
    memcpy(query.name, full.name, sizeof query.name);
    query.minimum = static_cast<int32_t>(full.minimum);
    query.maximum = static_cast<int32_t>(full.maximum);
    query.step = static_cast<int32_t>(full.step);
    query.default_value = static_cast<int32_t>(full.default_value);
    query.flags = full.flags;
    return 0;
}

bool is_known(unsigned request) {
    constexpr unsigned known[] = {
        VIDIOC_QUERYCAP,
        VIDIOC_ENUM_FMT,
        VIDIOC_ENUM_FRAMESIZES,
        VIDIOC_ENUM_FRAMEINTERVALS,
        VIDIOC_G_FMT,
        VIDIOC_TRY_FMT,
        VIDIOC_S_FMT,
        VIDIOC_G_PARM,
        VIDIOC_S_PARM,
        VIDIOC_G_SELECTION,
        VIDIOC_CROPCAP,
        VIDIOC_ENUMINPUT,
        VIDIOC_G_INPUT,
        VIDIOC_S_INPUT,
        VIDIOC_G_PRIORITY,
        VIDIOC_S_PRIORITY,
        VIDIOC_REQBUFS,
        VIDIOC_CREATE_BUFS,
        VIDIOC_QUERYBUF,
        VIDIOC_PREPARE_BUF,
        VIDIOC_QBUF,
        VIDIOC_DQBUF,
        VIDIOC_STREAMON,
        VIDIOC_STREAMOFF,
        VIDIOC_QUERYCTRL,
        VIDIOC_QUERY_EXT_CTRL,
        VIDIOC_QUERYMENU,
        VIDIOC_G_CTRL,
        VIDIOC_S_CTRL,
        VIDIOC_G_EXT_CTRLS,
        VIDIOC_S_EXT_CTRLS,
        VIDIOC_TRY_EXT_CTRLS,
        VIDIOC_SUBSCRIBE_EVENT,
        VIDIOC_UNSUBSCRIBE_EVENT,
        VIDIOC_DQEVENT,
    };
    for (const unsigned entry : known)
        if (entry == request) return true;
    return false;
}

/// The rig has closed its end: as in the kernel, where nothing of a device that is gone answers.
bool is_unplugged(int fd) {
    pollfd ours{fd, 0, 0};
    timespec now{};
    return raw_syscall(SYS_ppoll, arg(&ours), 1, arg(&now)) == 1 && (ours.revents & POLLHUP) != 0;
}

template <typename T>
T& as(void* argument) {
    return *static_cast<T*>(argument);
}

}  // namespace

int device_ioctl(Device& device, int fd, unsigned request, void* argument) {
    if (reinterpret_cast<uintptr_t>(argument) < lowest_address) {
        // Even with a bad pointer an unknown request is ENOTTY rather than EFAULT; no known one works without memory.
        return is_known(request) ? EFAULT : ENOTTY;
    }
    if (is_unplugged(fd)) return ENODEV;
    switch (request) {
        case VIDIOC_QUERYCAP:
            return query_capabilities(device, as<v4l2_capability>(argument));
        case VIDIOC_ENUM_FMT:
            return enum_format(device, as<v4l2_fmtdesc>(argument));
        case VIDIOC_ENUM_FRAMESIZES:
            return enum_frame_size(device, as<v4l2_frmsizeenum>(argument));
        case VIDIOC_ENUM_FRAMEINTERVALS:
            return enum_frame_interval(device, as<v4l2_frmivalenum>(argument));
        case VIDIOC_G_FMT:
            return get_format(device, as<v4l2_format>(argument));
        case VIDIOC_TRY_FMT:
            return try_format(device, as<v4l2_format>(argument));
        case VIDIOC_S_FMT:
            return set_format(device, as<v4l2_format>(argument));
        case VIDIOC_G_PARM:
            return get_parm(device, as<v4l2_streamparm>(argument));
        case VIDIOC_S_PARM:
            return set_parm(device, as<v4l2_streamparm>(argument));
        case VIDIOC_G_SELECTION:
            return get_selection(device, as<v4l2_selection>(argument));
        case VIDIOC_CROPCAP:
            return crop_capabilities(device, as<v4l2_cropcap>(argument));

        case VIDIOC_ENUMINPUT:
            return enum_input(as<v4l2_input>(argument));
        case VIDIOC_G_INPUT:
            as<int>(argument) = 0;
            return 0;
        case VIDIOC_S_INPUT:
            return outranked(device) ? EBUSY : as<int>(argument) != 0 ? EINVAL : 0;
        case VIDIOC_G_PRIORITY:
            as<uint32_t>(argument) = device.page->top_priority;
            return 0;
        case VIDIOC_S_PRIORITY:
            return set_priority(device, as<uint32_t>(argument));

        case VIDIOC_REQBUFS:
            return request_buffers(device, as<v4l2_requestbuffers>(argument));
        case VIDIOC_CREATE_BUFS:
            return create_buffers(device, as<v4l2_create_buffers>(argument));
        case VIDIOC_QUERYBUF:
            return query_buffer(device, as<v4l2_buffer>(argument));
        case VIDIOC_PREPARE_BUF:
            return prepare_buffer(device, as<v4l2_buffer>(argument));
        case VIDIOC_QBUF:
            return queue_buffer(device, as<v4l2_buffer>(argument));
        case VIDIOC_DQBUF:
            return dequeue_buffer(device, fd, as<v4l2_buffer>(argument));
        case VIDIOC_STREAMON:
            return stream_on(device, as<uint32_t>(argument));
        case VIDIOC_STREAMOFF:
            return stream_off(device, fd, as<uint32_t>(argument));

        case VIDIOC_QUERYCTRL:
            return query_short(device, as<v4l2_queryctrl>(argument));
        case VIDIOC_QUERY_EXT_CTRL:
            return query_control(device, as<v4l2_query_ext_ctrl>(argument));
        case VIDIOC_QUERYMENU:
            return query_menu(device, as<v4l2_querymenu>(argument));
        case VIDIOC_G_CTRL:
            return get_control(device, as<v4l2_control>(argument));
        case VIDIOC_S_CTRL:
            return set_control(device, as<v4l2_control>(argument));
        case VIDIOC_G_EXT_CTRLS:
        case VIDIOC_S_EXT_CTRLS:
        case VIDIOC_TRY_EXT_CTRLS:
            return ext_controls(device, request, as<v4l2_ext_controls>(argument));
        case VIDIOC_SUBSCRIBE_EVENT:
            return subscribe_event(device, as<v4l2_event_subscription>(argument));
        case VIDIOC_UNSUBSCRIBE_EVENT:
            return unsubscribe_event(device, as<v4l2_event_subscription>(argument));
        case VIDIOC_DQEVENT:
            return dequeue_event(device, fd, as<v4l2_event>(argument));
        default:
            return ENOTTY;
    }
}

}  // namespace camrig::device
