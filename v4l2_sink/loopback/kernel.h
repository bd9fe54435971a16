#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace camrig::device {

/// The system calls that this sink makes on v4l2loopback's devices. An interface, so that tests can replace the driver
/// by fakes of each of its versions. Calls that can fail return -errno. Any thread.
class LoopbackKernel {
public:
    virtual ~LoopbackKernel() = default;
    virtual bool exists(const std::string& path) = 0;
    /// The first line of a small file, as in /sys.
    virtual std::optional<std::string> read_line(const std::string& path) = 0;
    /// Opens with O_RDWR | O_NONBLOCK.
    virtual int open(const std::string& path) = 0;
    virtual void close(int fd) = 0;
    virtual int ioctl(int fd, unsigned long request, void* argument) = 0;
    /// mmap() for writing; null if it fails.
    virtual std::byte* map(int fd, std::size_t bytes, std::int64_t offset) = 0;
    virtual void unmap(std::byte* data, std::size_t bytes) = 0;
    virtual std::int64_t write(int fd, std::span<const std::byte> bytes) = 0;
};

/// The one that makes the system calls.
LoopbackKernel& linux_kernel();

}  // namespace camrig::device
