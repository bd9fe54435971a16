#include "core/base/write_file.h"

#include <cerrno>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/base/unique_fd.h"

namespace camrig {

namespace {

Error cannot_write(const std::string& name) {
    return {ErrorKind::unavailable, name + ": cannot be written: " + std::strerror(errno)};
}

}  // namespace

Result<void> write_all(int fd, std::span<const std::byte> bytes, const std::string& name) {
    while (!bytes.empty()) {
        const ssize_t count = ::write(fd, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return std::unexpected(cannot_write(name));
        bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
    return {};
}

Result<void> write_atomically(const std::filesystem::path& file, std::span<const std::byte> bytes, mode_t mode) {
    std::string temporary = file.string() + ".XXXXXX";
    const UniqueFd fd(::mkostemp(temporary.data(), O_CLOEXEC));
    if (!fd) return std::unexpected(cannot_write(file.string()));
    auto written = write_all(fd.get(), bytes, file.string());
    const mode_t mask = ::umask(0);
    ::umask(mask);
    if (written && (::fchmod(fd.get(), mode & ~mask) != 0 || ::rename(temporary.c_str(), file.c_str()) != 0))
        written = std::unexpected(cannot_write(file.string()));
    if (!written) ::unlink(temporary.c_str());
    return written;
}

}  // namespace camrig
