#pragma once

#include <optional>
#include <string>

#include "core/base/result.h"
#include "v4l2_sink/loopback/kernel.h"

namespace camrig::device {

/// What the loaded version of v4l2loopback can do (docs/decisions/0031).
struct LoopbackFeatures {
    std::string version;         ///< "0.15.4"; "0.12" or "0.13" where the module does not tell more
    bool adds_devices = false;   ///< since 0.13: /dev/v4l2loopback makes and removes devices
    bool tells_readers = false;  ///< since 0.13: an event says whether somebody reads
    bool streams = false;        ///< since 0.14: QBUF keeps the buffer's timestamp and sets its sequence number
};

/// "/dev/videoN".
std::string video_path(int number);

/// The kernel module as a whole: its features, and creating and removing its devices. No state; any thread.
/// Messages of errors are for the user: they say what to run.
class LoopbackModule {
public:
    explicit LoopbackModule(LoopbackKernel& kernel) : kernel_(kernel) {}

    /// unavailable: the module is not loaded. unsupported: older than 0.12.
    Result<LoopbackFeatures> features() const;

    struct Provided {
        LoopbackFeatures features;
        bool is_new = false;
    };
    /// Whether provide() would succeed, as far as one sees without trying; changes nothing. Errors as of provide().
    Result<LoopbackFeatures> can_provide(int number, const std::string& label) const;
    /// Creates /dev/video<number> with this card label, unless the node exists, whichever driver's it is. Errors as of
    /// features(), and not_found (this version adds no devices while loaded), unauthorized (no access to the module's
    /// control node), unavailable (the module refused), already_exists (another driver has the number).
    Result<Provided> provide(int number, const std::string& label) const;
    /// Removes the device. unavailable: some program has it open; unauthorized; not_found.
    Result<void> remove(int number) const;

private:
    LoopbackKernel& kernel_;
};

}  // namespace camrig::device
