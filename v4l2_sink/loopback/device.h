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

/// One /dev/videoN of v4l2loopback, opened as its writer. Knows what each generation of the module wants to be told,
/// and in which order. When it goes, a program that reads waits for the next writer of the same format.
///
/// Thread: none of its own; show() and the rest may come from different threads, one at a time (LoopbackSink sees to
/// it).
class LoopbackDevice {
public:
    /// Four, whatever the reader asks for (module.cpp says why).
    static constexpr std::uint32_t buffer_count = 4;

    /// A device that is being read keeps the format that its readers have: format() tells, and differs then from
    /// `wanted`. Errors: not_found (no such node), unauthorized, already_exists (another driver's device, or another
    /// program writes to it), unsupported (it holds a format that is none of ours).
    static Result<std::unique_ptr<LoopbackDevice>> open(LoopbackKernel& kernel, const LoopbackFeatures& features,
                                                        int number, const LoopbackFormat& wanted);
    /// Whether it can be opened and is the module's; changes nothing. Errors as of open().
    static Result<void> check(LoopbackKernel& kernel, int number);
    LoopbackDevice(const LoopbackDevice&) = delete;
    LoopbackDevice& operator=(const LoopbackDevice&) = delete;
    ~LoopbackDevice();

    const LoopbackFormat& format() const { return format_; }
    /// Buffers it has; programs need four.
    int buffers() const { return buffers_; }

    /// Gives a picture to whoever reads. The first one makes it a camera for programs that look for one.
    /// `stamp_us` (CLOCK_MONOTONIC) is what readers get since 0.14; before, it is the time of this call.
    Result<void> show(std::span<const std::byte> bytes, std::int64_t stamp_us);

    /// Becomes ready for POLLPRI when readers come or go; -1 where the module does not tell.
    int readers_fd() const { return tells_readers_ ? fd_ : -1; }
    /// Does any program read? Nothing where the module does not tell. unavailable: the device is gone.
    Result<std::optional<bool>> has_readers();
    /// Any reader may set the rate of the device, which is what it tells the next one. True if one did; it is the
    /// camera's again now.
    bool restore_rate();
    void change_rate(const Rate& rate);
    /// The format may be changed again, by whoever opens it next.
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
