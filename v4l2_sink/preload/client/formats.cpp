
#include <cerrno>

#include <errno.h>
#include <string.h>

#include "v4l2_sink/preload/client/device.h"
#include "v4l2_sink/preload/number_fourccs.h"

namespace camrig::device {

namespace {

constexpr uint32_t page_bytes = 4096;

struct FormatName {
    uint32_t fourcc;
    const char* name;  // as the kernel calls it (v4l2-ioctl.c)
};
constexpr FormatName format_names[] = {
    {V4L2_PIX_FMT_YUYV, "YUYV 4:2:2"},         {V4L2_PIX_FMT_MJPEG, "Motion-JPEG"},
    {V4L2_PIX_FMT_YUV420, "Planar YUV 4:2:0"}, {V4L2_PIX_FMT_NV12, "Y/CbCr 4:2:0"},
    {V4L2_PIX_FMT_BGR24, "24-bit BGR 8-8-8"},
};

void copy_text(uint8_t* to, size_t room, const char* text) {
    size_t length = strlen(text);
    if (length >= room) length = room - 1;
    memset(to, 0, room);
    memcpy(to, text, length);
}

uint32_t bytes_per_line(uint32_t fourcc, uint32_t width) {
    switch (fourcc) {
        case V4L2_PIX_FMT_YUYV:
            return 2 * width;
        case V4L2_PIX_FMT_BGR24:
            return 3 * width;
        case V4L2_PIX_FMT_MJPEG:
            return 0;
        default:
            if (const NumberFourcc* const numbers = number_fourcc(fourcc)) return bytes_a_number(*numbers) * width;
            return width;  // of the luma plane
    }
}

/// In how many of the listed sizes a format comes; 0: it is not there.
uint32_t sizes_of(const camrig_description& d, uint32_t fourcc) {
    for (uint32_t i = 0; i < d.format_count; ++i)
        if (d.fourcc[i] == fourcc) return (d.one_size_mask >> i & 1u) != 0 ? 1 : d.size_count;
    return 0;
}

bool has_format(const camrig_description& d, uint32_t fourcc) {
    return sizes_of(d, fourcc) > 0;
}

bool has_size(const camrig_description& d, uint32_t fourcc, uint32_t width, uint32_t height) {
    for (uint32_t i = 0; i < sizes_of(d, fourcc); ++i)
        if (d.width[i] == width && d.height[i] == height) return true;
    return false;
}

/// The listed size with the most similar area overlap, as the UVC driver chooses it.
uint32_t nearest_size(const camrig_description& d, uint32_t fourcc, uint32_t width, uint32_t height) {
    uint32_t best = 0;
    uint64_t best_distance = UINT64_MAX;
    for (uint32_t i = 0; i < sizes_of(d, fourcc); ++i) {
        const uint64_t common =
            uint64_t{d.width[i] < width ? d.width[i] : width} * (d.height[i] < height ? d.height[i] : height);
        const uint64_t distance = uint64_t{d.width[i]} * d.height[i] + uint64_t{width} * height - 2 * common;
        if (distance < best_distance) {
            best_distance = distance;
            best = i;
        }
    }
    return best;
}

void fill_pixels(v4l2_format& format, const camrig_format& wanted) {
    const uint32_t type = format.type;
    memset(&format, 0, sizeof format);
    format.type = type;
    v4l2_pix_format& pixels = format.fmt.pix;
    pixels.width = wanted.width;
    pixels.height = wanted.height;
    pixels.pixelformat = wanted.fourcc;
    pixels.field = V4L2_FIELD_NONE;
    pixels.bytesperline = bytes_per_line(wanted.fourcc, wanted.width);
    pixels.sizeimage = image_bytes(wanted.fourcc, wanted.width, wanted.height);
    pixels.priv = V4L2_PIX_FMT_PRIV_MAGIC;
    // Every consumer decodes YUV from a camera as BT.601, limited range, whatever its size; MJPEG is JFIF.
    const bool jpeg = wanted.fourcc == V4L2_PIX_FMT_MJPEG;
    const bool rgb = wanted.fourcc == V4L2_PIX_FMT_BGR24;
    pixels.colorspace = jpeg ? V4L2_COLORSPACE_JPEG : V4L2_COLORSPACE_SRGB;
    pixels.ycbcr_enc = V4L2_YCBCR_ENC_601;
    pixels.quantization = jpeg || rgb ? V4L2_QUANTIZATION_FULL_RANGE : V4L2_QUANTIZATION_LIM_RANGE;
    pixels.xfer_func = V4L2_XFER_FUNC_SRGB;
    if (number_fourcc(wanted.fourcc) == nullptr) return;
    pixels.colorspace = V4L2_COLORSPACE_RAW;
    pixels.ycbcr_enc = V4L2_YCBCR_ENC_DEFAULT;
    pixels.quantization = V4L2_QUANTIZATION_FULL_RANGE;
    pixels.xfer_func = V4L2_XFER_FUNC_NONE;
}

/// What the device would make of a requested format.
camrig_format adjusted(const Device& device, const v4l2_format& requested) {
    camrig_format result = device.format;
    const v4l2_pix_format& pixels = requested.fmt.pix;
    if (has_format(device.description, pixels.pixelformat))
        result.fourcc = pixels.pixelformat;
    else
        result.fourcc = device.description.fourcc[0];
    const uint32_t size = nearest_size(device.description, result.fourcc, pixels.width, pixels.height);
    result.width = device.description.width[size];
    result.height = device.description.height[size];
    return result;
}

int choose(Device& device, const camrig_format& format) {
    camrig_request request{};
    request.type = camrig_request_set_format;
    request.u.format = format;
    camrig_reply reply;
    if (const int problem = transact(device, request, reply, nullptr)) return problem;
    device.format = format;
    device.format_chosen = true;
    return 0;
}

void fill_parm(v4l2_streamparm& parm, const camrig_rate& rate) {
    const uint32_t type = parm.type;
    memset(&parm, 0, sizeof parm);
    parm.type = type;
    parm.parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
    parm.parm.capture.timeperframe.numerator = rate.den;
    parm.parm.capture.timeperframe.denominator = rate.num;
}

}  // namespace

uint32_t image_bytes(uint32_t fourcc, uint32_t width, uint32_t height) {
    const uint32_t pixels = width * height;
    switch (fourcc) {
        case V4L2_PIX_FMT_YUYV:
            return 2 * pixels;
        case V4L2_PIX_FMT_BGR24:
            return 3 * pixels;
        case V4L2_PIX_FMT_MJPEG:
            return 2 * pixels + page_bytes;  // more than libjpeg ever makes of noise at q 90
        default:
            if (const NumberFourcc* const numbers = number_fourcc(fourcc)) return bytes_a_number(*numbers) * pixels;
            return pixels + 2 * ((width + 1) / 2) * ((height + 1) / 2);
    }
}

int refresh_format(Device& device) {
    if (device.buffer_count > 0) return 0;
    camrig_request request{};
    request.type = camrig_request_get_format;
    camrig_reply reply;
    if (const int problem = transact(device, request, reply, nullptr)) return problem;
    const camrig_format& format = reply.u.format;
    if (has_size(device.description, format.fourcc, format.width, format.height) && format.rate.num > 0 &&
        format.rate.den > 0)
        device.format = format;
    return 0;
}

bool outranked(const Device& device) {
    return device.priority < __atomic_load_n(&device.page->top_priority, __ATOMIC_RELAXED);
}

int query_capabilities(Device& device, v4l2_capability& capability) {
    memset(&capability, 0, sizeof capability);
    copy_text(capability.driver, sizeof capability.driver, "camrig");
    copy_text(capability.card, sizeof capability.card, device.description.card);
    copy_text(capability.bus_info, sizeof capability.bus_info, device.description.bus_info);
    capability.version = 6u << 16 | 1u << 8;  // the kernel interface this follows
    capability.device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING | V4L2_CAP_EXT_PIX_FORMAT;
    capability.capabilities = capability.device_caps | V4L2_CAP_DEVICE_CAPS;
    return 0;
}

int enum_format(Device& device, v4l2_fmtdesc& desc) {
    const uint32_t index = desc.index, type = desc.type;
    if (type != V4L2_BUF_TYPE_VIDEO_CAPTURE || index >= device.description.format_count) return EINVAL;
    memset(&desc, 0, sizeof desc);
    desc.index = index;
    desc.type = type;
    desc.pixelformat = device.description.fourcc[index];
    if (desc.pixelformat == V4L2_PIX_FMT_MJPEG) desc.flags = V4L2_FMT_FLAG_COMPRESSED;
    for (const FormatName& entry : format_names)
        if (entry.fourcc == desc.pixelformat) copy_text(desc.description, sizeof desc.description, entry.name);
    if (const NumberFourcc* const numbers = number_fourcc(desc.pixelformat))
        copy_text(desc.description, sizeof desc.description, numbers->name);
    return 0;
}

int enum_frame_size(Device& device, v4l2_frmsizeenum& size) {
    const uint32_t index = size.index, fourcc = size.pixel_format;
    if (index >= sizes_of(device.description, fourcc)) return EINVAL;
    memset(&size, 0, sizeof size);
    size.index = index;
    size.pixel_format = fourcc;
    size.type = V4L2_FRMSIZE_TYPE_DISCRETE;
    size.discrete.width = device.description.width[index];
    size.discrete.height = device.description.height[index];
    return 0;
}

int enum_frame_interval(Device& device, v4l2_frmivalenum& interval) {
    const v4l2_frmivalenum asked = interval;
    if (!has_size(device.description, asked.pixel_format, asked.width, asked.height) ||
        asked.index >= device.description.rate_count)
        return EINVAL;
    memset(&interval, 0, sizeof interval);
    interval.index = asked.index;
    interval.pixel_format = asked.pixel_format;
    interval.width = asked.width;
    interval.height = asked.height;
    interval.type = V4L2_FRMIVAL_TYPE_DISCRETE;
    interval.discrete.numerator = device.description.rate[asked.index].den;
    interval.discrete.denominator = device.description.rate[asked.index].num;
    return 0;
}

int get_format(Device& device, v4l2_format& format) {
    if (format.type != V4L2_BUF_TYPE_VIDEO_CAPTURE) return EINVAL;
    Locked guard(device.lock);
    if (const int problem = refresh_format(device)) return problem;
    fill_pixels(format, device.format);
    return 0;
}

int try_format(Device& device, v4l2_format& format) {
    if (format.type != V4L2_BUF_TYPE_VIDEO_CAPTURE) return EINVAL;
    Locked guard(device.lock);
    fill_pixels(format, adjusted(device, format));
    return 0;
}

int set_format(Device& device, v4l2_format& format) {
    if (format.type != V4L2_BUF_TYPE_VIDEO_CAPTURE) return EINVAL;
    if (outranked(device)) return EBUSY;
    Locked guard(device.lock);
    if (device.buffer_count > 0) return EBUSY;
    if (const int problem = refresh_format(device)) return problem;
    const camrig_format wanted = adjusted(device, format);
    if (const int problem = choose(device, wanted)) return problem;
    fill_pixels(format, wanted);
    return 0;
}

int get_parm(Device& device, v4l2_streamparm& parm) {
    if (parm.type != V4L2_BUF_TYPE_VIDEO_CAPTURE) return EINVAL;
    Locked guard(device.lock);
    if (const int problem = refresh_format(device)) return problem;
    fill_parm(parm, device.format.rate);
    return 0;
}

int set_parm(Device& device, v4l2_streamparm& parm) {
    if (parm.type != V4L2_BUF_TYPE_VIDEO_CAPTURE) return EINVAL;
    if (outranked(device)) return EBUSY;
    Locked guard(device.lock);
    if (device.streaming) return EBUSY;
    if (const int problem = refresh_format(device)) return problem;

    // Nearest listed interval; an interval of 0 asks for the default.
    const v4l2_fract requested = parm.parm.capture.timeperframe;
    const camrig_description& d = device.description;
    uint32_t best = 0;
    if (requested.numerator != 0 && requested.denominator != 0) {
        double best_distance = 1e300;
        const double seconds = static_cast<double>(requested.numerator) / requested.denominator;
        for (uint32_t i = 0; i < d.rate_count; ++i) {
            double distance = static_cast<double>(d.rate[i].den) / d.rate[i].num - seconds;
            if (distance < 0) distance = -distance;
            if (distance < best_distance) {
                best_distance = distance;
                best = i;
            }
        }
    }
    camrig_format wanted = device.format;
    wanted.rate = d.rate[best];
    if (const int problem = choose(device, wanted)) return problem;
    fill_parm(parm, wanted.rate);
    return 0;
}

int get_selection(Device& device, v4l2_selection& selection) {
    // Both spellings of the buffer type are allowed here (kernel 4.13 and later).
    if (selection.type != V4L2_BUF_TYPE_VIDEO_CAPTURE && selection.type != V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE)
        return EINVAL;
    if (selection.target != V4L2_SEL_TGT_CROP_DEFAULT && selection.target != V4L2_SEL_TGT_CROP_BOUNDS) return EINVAL;
    Locked guard(device.lock);
    if (const int problem = refresh_format(device)) return problem;
    selection.r = {0, 0, device.format.width, device.format.height};
    return 0;
}

int crop_capabilities(Device& device, v4l2_cropcap& cropcap) {
    if (cropcap.type != V4L2_BUF_TYPE_VIDEO_CAPTURE && cropcap.type != V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE)
        return EINVAL;
    Locked guard(device.lock);
    if (const int problem = refresh_format(device)) return problem;
    cropcap.bounds = cropcap.defrect = {0, 0, device.format.width, device.format.height};
    cropcap.pixelaspect = {1, 1};
    return 0;
}

}  // namespace camrig::device
