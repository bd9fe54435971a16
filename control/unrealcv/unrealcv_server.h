#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "control/unrealcv/pictures.h"
#include "core/base/connection_counts.h"
#include "core/base/result.h"
#include "core/engine/command.h"
#include "core/stream/frame_bus.h"

namespace camrig::unrealcv {

/// The bounds of the door; tests shorten them. Of a request: max_request_bytes.
struct UnrealCvLimits {
    using Duration = std::chrono::milliseconds;

    std::size_t connections = 32;
    std::size_t waiting_bytes = std::size_t{4} << 20;    ///< requests of one connection; then it is not read
    std::size_t picture_bytes = std::size_t{512} << 20;  ///< that are made or being sent, of all
    Duration stalled_after{10'000};  ///< a client that takes no byte of an answer for so long is closed
};

struct UnrealCvOptions {
    std::string host = "127.0.0.1";  ///< loopback: the protocol knows no passwords
    std::uint16_t port = 0;          ///< 0: any free one
    std::string name;                ///< of the scene, for the greeting
    std::filesystem::path folder;    ///< for files; empty: none are written
    Depth depth = Depth::plane_cm;
    UnrealCvLimits limits = {};
};

/// Speaks UnrealCV's protocol, for its Python client and what is written with it: cameras, pictures and objects of this
/// rig by UnrealCV's commands (docs/unrealcv.md).
///
/// One thread of its own serves all connections with coroutines. All calls from any thread; throws nothing.
class UnrealCvServer {
public:
    /// Listens before it returns; `commands` and `frames` outlive stop(). invalid_argument: a host beyond loopback, or
    /// a folder that is none; unavailable: cannot be listened on.
    static Result<std::unique_ptr<UnrealCvServer>> create(engine::CommandPort& commands, stream::FrameFetcher& frames,
                                                          UnrealCvOptions options);
    ~UnrealCvServer();
    UnrealCvServer(const UnrealCvServer&) = delete;
    UnrealCvServer& operator=(const UnrealCvServer&) = delete;

    std::uint16_t port() const;
    ConnectionCounts counts() const;
    /// Closes every connection and joins the thread. Twice is fine.
    void stop();

private:
    struct Impl;
    explicit UnrealCvServer(std::unique_ptr<Impl> impl);
    const std::unique_ptr<Impl> impl_;
};

}  // namespace camrig::unrealcv
