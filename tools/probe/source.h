#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/base/image_size.h"
#include "core/base/result.h"
#include "core/base/time.h"

namespace camrig::probe {

/// One picture as a program got it.
struct ProbedPicture {
    TimeNs arrival_ns = 0;                 ///< CLOCK_MONOTONIC, when the program had it in hands
    std::optional<TimeNs> stamp_ns;        ///< what the source says of its time; see Source::stamps_are_monotonic
    std::optional<std::int64_t> sequence;  ///< the source's own count
    bool damaged = false;                  ///< the source or the decoder says so: error flag, short, broken JPEG
    ImageSize size;
    std::span<const std::byte> gray;  ///< its brightness, one byte a pixel; empty: not decodable. Valid until next()
};

struct SourceOptions {
    TimeNs timeout_ns = 5 * ns_per_s;  ///< for opening; a stream that is silent for so long has failed, too
    std::string device_format;         ///< fourcc; empty: as the device is
    std::string token;                 ///< sent to HTTP sources as a bearer token when not empty
    bool rtsp_over_udp = false;
};

/// One device or stream, opened as an ordinary client does. One thread.
class Source {
public:
    virtual ~Source() = default;
    /// "device", "http", "rtsp"
    virtual std::string_view kind() const = 0;
    /// Words for people: "YUYV", "MJPEG", "H264". May be empty before the first picture.
    virtual std::string format() const = 0;
    /// Stamps are CLOCK_MONOTONIC, so that arrival - stamp is the latency; else they only tell distances.
    virtual bool stamps_are_monotonic() const = 0;
    /// The next picture; nothing when none came until then. An error is the end of the source.
    virtual Result<std::optional<ProbedPicture>> next(TimeNs until_ns) = 0;
};

/// A path is a device; http:// and rtsp:// are what they say. Takes no longer than the timeout. Errors do not name the
/// source: the caller does.
Result<std::unique_ptr<Source>> open_source(const std::string& address, const SourceOptions& options);

Result<std::unique_ptr<Source>> open_device_source(const std::string& path, const SourceOptions& options);
Result<std::unique_ptr<Source>> open_http_source(const std::string& url, const SourceOptions& options);
Result<std::unique_ptr<Source>> open_rtsp_source(const std::string& url, const SourceOptions& options);

}  // namespace camrig::probe
