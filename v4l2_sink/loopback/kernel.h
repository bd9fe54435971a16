#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace camrig::device {

/// The system calls by which this sink talks to v4l2loopback: a seam, behind which tests put drivers of every
/// generation. Calls that can fail give -errno. Any thread.
class LoopbackKernel {
public:
    virtual ~LoopbackKernel() = default;
    virtual bool exists(const std::string& path) = 0;
    /// The first line of a small file, as in /sys.
    virtual std::optional<std::string> read_line(const std::string& path) = 0;
    /// For reading and writing, without blocking.
    virtual int open(const std::string& path) = 0;
    virtual void close(int fd) = 0;
    virtual int ioctl(int fd, unsigned long request, void* argument) = 0;
    /// Null if it cannot be mapped.
    virtual std::byte* map(int fd, std::size_t bytes, std::int64_t offset) = 0;
    virtual void unmap(std::byte* data, std::size_t bytes) = 0;
    virtual std::int64_t write(int fd, std::span<const std::byte> bytes) = 0;
};

/// The real one.
LoopbackKernel& linux_kernel();

}  // namespace camrig::device
