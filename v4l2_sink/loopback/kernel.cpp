#include "v4l2_sink/loopback/kernel.h"

#include <cerrno>
#include <fstream>

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace camrig::device {

namespace {

class LinuxKernel final : public LoopbackKernel {
public:
    bool exists(const std::string& path) override { return ::access(path.c_str(), F_OK) == 0; }
    std::optional<std::string> read_line(const std::string& path) override {
        std::ifstream file(path);
        std::string line;
        return std::getline(file, line) ? std::optional(line) : std::nullopt;
    }
    int open(const std::string& path) override {
        const int fd = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
        return fd < 0 ? -errno : fd;
    }
    void close(int fd) override { ::close(fd); }
    int ioctl(int fd, unsigned long request, void* argument) override {
        int result = 0;
        do {
            result = ::ioctl(fd, request, argument);
        } while (result < 0 && errno == EINTR);
        return result < 0 ? -errno : result;
    }
    std::byte* map(int fd, std::size_t bytes, std::int64_t offset) override {
        void* data = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, offset);
        return data == MAP_FAILED ? nullptr : static_cast<std::byte*>(data);
    }
    void unmap(std::byte* data, std::size_t bytes) override { ::munmap(data, bytes); }
    std::int64_t write(int fd, std::span<const std::byte> bytes) override {
        const ssize_t written = ::write(fd, bytes.data(), bytes.size());
        return written < 0 ? -errno : written;
    }
};

}  // namespace

LoopbackKernel& linux_kernel() {
    static LinuxKernel kernel;
    return kernel;
}

}  // namespace camrig::device
