#pragma once

#include <optional>
#include <string>

#include "core/base/result.h"
#include "v4l2_sink/loopback/kernel.h"

namespace camrig::device {

/// What the loaded v4l2loopback can do; its generations differ much (docs/decisions/0031).
struct LoopbackFeatures {
    std::string version;         ///< "0.15.4"; "0.12" or "0.13" where the module does not tell more
    bool adds_devices = false;   ///< since 0.13: /dev/v4l2loopback makes and removes devices
    bool tells_readers = false;  ///< since 0.13: an event says whether somebody reads
    bool streams = false;        ///< since 0.14: queued buffers keep the stamp and get a sequence number
};

/// "/dev/videoN".
std::string video_path(int number);

/// The kernel module as a whole: what it can, and which devices it has. No state; any thread.
/// Errors are for the user: they say what to run.
class LoopbackModule {
public:
    explicit LoopbackModule(LoopbackKernel& kernel) : kernel_(kernel) {}

    /// unavailable: the module is not loaded. unsupported: older than 0.12.
    Result<LoopbackFeatures> features() const;

    struct Provided {
        LoopbackFeatures features;
        bool is_new = false;
    };
    /// What provide() would say; changes nothing.
    Result<LoopbackFeatures> can_provide(int number, const std::string& label) const;
    /// Makes /dev/video<number> of this card label unless it is there, whoever owns it.
    Result<Provided> provide(int number, const std::string& label) const;
    /// unavailable: some program has the device open.
    Result<void> remove(int number) const;

private:
    LoopbackKernel& kernel_;
};

}  // namespace camrig::device
