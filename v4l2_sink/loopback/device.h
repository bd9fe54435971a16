#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/base/result.h"
#include "core/base/time.h"
#include "v4l2_sink/loopback/format.h"
#include "v4l2_sink/loopback/kernel.h"
#include "v4l2_sink/loopback/module.h"

namespace camrig::device {

/// One /dev/videoN of v4l2loopback, opened as its writer (V4L2_BUF_TYPE_VIDEO_OUTPUT). Handles the differences between
/// the versions of the module. When it is destroyed, programs that read the device stay connected and wait for the next
/// writer, which has to use the same format.
///
/// Thread: any, but one call at a time (LoopbackSink holds a mutex).
class LoopbackDevice {
public:
    /// Four, whatever the reader asks for (module.cpp says why).
    static constexpr std::uint32_t buffer_count = 4;

    /// Sets the format, unless a program reads the device already: then the device keeps that program's format, and
    /// format() differs from `wanted`. Errors: not_found (no such node), unauthorized (permissions of the node),
    /// already_exists (another driver's device, or another program writes to it), unsupported (the kept format is none
    /// that camrig offers, or too few buffers), unavailable (another system call failed).
    static Result<std::unique_ptr<LoopbackDevice>> open(LoopbackKernel& kernel, const LoopbackFeatures& features,
                                                        int number, const LoopbackFormat& wanted);
    /// Whether the node can be opened and belongs to v4l2loopback; changes nothing. Errors as of open().
    static Result<void> check(LoopbackKernel& kernel, int number);
    LoopbackDevice(const LoopbackDevice&) = delete;
    LoopbackDevice& operator=(const LoopbackDevice&) = delete;
    ~LoopbackDevice();

    const LoopbackFormat& format() const { return format_; }
    /// Buffers that the module allocated, 1 to buffer_count: fewer while other programs hold some. 0 before 0.14.
    int buffers() const { return buffers_; }

    /// Shows one picture in format() to all readers. From the first call on the device reports V4L2_CAP_VIDEO_CAPTURE,
    /// so that programs list it as a camera (the module's exclusive_caps).
    /// `stamp_us` (CLOCK_MONOTONIC) becomes v4l2_buffer::timestamp since 0.14; before, that is the time of this call.
    Result<void> show(std::span<const std::byte> bytes, std::int64_t stamp_us);

    /// To be polled for POLLPRI, which is set when a reader comes or goes; -1 if the module has no such event (before
    /// 0.13).
    int readers_fd() const { return tells_readers_ ? fd_ : -1; }
    /// Whether any program reads; nullopt if the module has no such event. unavailable: the device was removed.
    Result<std::optional<bool>> has_readers();
    /// Sets the frame interval back to the camera's: any reader may change it by VIDIOC_S_PARM, and the next reader
    /// would be told the changed one. True if it had been changed.
    bool restore_rate();
    /// Sets another frame interval. It only informs readers: pictures come when show() is called.
    void change_rate(const Rate& rate);
    /// Clears the module's control keep_format: whoever opens the device next may set another format.
    void release_format();

private:
    struct Mapping {
        std::byte* data = nullptr;
        std::size_t bytes = 0;
    };

    LoopbackDevice(LoopbackKernel& kernel, int number, int fd) : kernel_(kernel), number_(number), fd_(fd) {}

    static Result<std::unique_ptr<LoopbackDevice>> open_node(LoopbackKernel& kernel, int number);
    Result<void> check_writers();
    Result<void> set_format(const LoopbackFormat& wanted);
    Result<void> set_up_buffers();
    void set_rate();
    void set_keep_format(bool keep);
    Result<void> queue(std::span<const std::byte> bytes, std::int64_t stamp_us);
    Result<void> write(std::span<const std::byte> bytes);
    std::unexpected<Error> failed(const char* what, int problem) const;

    LoopbackKernel& kernel_;
    const int number_;
    const int fd_;
    LoopbackFormat format_;
    int buffers_ = 0;
    bool streams_ = false;
    bool tells_readers_ = false;
    bool has_readers_ = false;
    bool shown_ = false;
    std::array<Mapping, buffer_count> mappings_;
};

}  // namespace camrig::device
