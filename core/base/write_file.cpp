#include "core/base/write_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>

#include <sys/stat.h>
#include <unistd.h>

#include "core/base/unique_fd.h"

namespace camrig {

Result<void> write_atomically(const std::filesystem::path& file, std::span<const std::byte> bytes) {
    std::string temporary = file.string() + ".XXXXXX";
    const auto failed = [&] {
        Error why{ErrorKind::unavailable, file.string() + ": cannot be written: " + std::strerror(errno)};
        ::unlink(temporary.c_str());
        return std::unexpected(std::move(why));
    };
    UniqueFd fd(::mkstemp(temporary.data()));
    if (!fd) return failed();
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t count = ::write(fd.get(), bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno != EINTR) return failed();
        done += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
    }
    const mode_t mask = ::umask(0);
    ::umask(mask);
    if (::fchmod(fd.get(), 0666 & ~mask) != 0 || ::rename(temporary.c_str(), file.c_str()) != 0) return failed();
    return {};
}

}  // namespace camrig
