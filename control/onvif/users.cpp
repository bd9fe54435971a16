#include "control/onvif/users.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "control/onvif/xml.h"
#include "core/base/unique_fd.h"

namespace camrig::onvif {
namespace {

constexpr std::size_t max_file_bytes = 64 * 1024, max_user_name = 64, min_password = 8, max_password = 128;

bool is_printable(std::string_view text, char first) {
    return std::ranges::all_of(text, [first](char one) { return one >= first && one <= '~'; });
}

/// Without it, and what was before the next blank.
std::string_view take_word(std::string_view& line) {
    line = trimmed(line);
    const std::string_view word = line.substr(0, line.find_first_of(" \t"));
    line = trimmed(line.substr(word.size()));
    return word;
}

Result<User> read_user(std::string_view line) {
    const auto refuse = [](std::string why) { return error(ErrorKind::invalid_argument, std::move(why)); };
    const std::string_view name = take_word(line), role_name = take_word(line);
    if (name.empty() || name.size() > max_user_name || !is_printable(name, '!') || name.contains('"'))
        return refuse("a name is 1 to 64 printable characters of ASCII without blanks and quotes");
    const auto roles = names_of(std::type_identity<Role>{});
    const auto role = std::ranges::find(roles, role_name, &Named<Role>::name);
    if (role == roles.end()) return refuse("after the name comes a role: administrator, operator or user");
    if (line.size() < min_password || line.size() > max_password || !is_printable(line, ' '))
        return refuse("after the role comes a password of 8 to 128 printable characters of ASCII");
    return User{std::string(name), role->value, std::string(line)};
}

/// Whole; of the file that was opened, whatever its name means by then.
Result<std::string> read_private_file(const std::filesystem::path& file) {
    const UniqueFd opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    struct stat facts{};
    if (opened.get() < 0 || ::fstat(opened.get(), &facts) != 0)
        return error(ErrorKind::unavailable, std::string("cannot be read: ") + std::strerror(errno));
    if (!S_ISREG(facts.st_mode)) return error(ErrorKind::invalid_argument, "is no file");
    if ((facts.st_mode & 077) != 0)
        return error(ErrorKind::invalid_argument, "holds passwords and can be read or written by others; chmod 600 it");
    std::string text(max_file_bytes + 1, '\0');
    std::size_t size = 0;
    while (size < text.size()) {
        const ssize_t got = ::read(opened.get(), text.data() + size, text.size() - size);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return error(ErrorKind::unavailable, std::string("cannot be read: ") + std::strerror(errno));
        if (got == 0) break;
        size += static_cast<std::size_t>(got);
    }
    if (size > max_file_bytes) return error(ErrorKind::invalid_argument, "is larger than 64 KiB");
    text.resize(size);
    return text;
}

}  // namespace

Result<std::vector<User>> read_users_file(const std::filesystem::path& file) {
    const auto text = read_private_file(file);
    if (!text) return at(file.string(), text.error());
    std::vector<User> users;
    std::string_view rest = *text;
    for (int number = 1; !rest.empty(); ++number) {
        const std::size_t end = std::min(rest.find('\n'), rest.size());
        const std::string_view line = trimmed(rest.substr(0, end));
        rest.remove_prefix(std::min(end + 1, rest.size()));
        if (line.empty() || line.starts_with('#')) continue;
        const std::string where = file.string() + ":" + std::to_string(number);
        auto user = read_user(line);
        if (!user) return at(where, user.error());
        if (std::ranges::find(users, user->name, &User::name) != users.end())
            return error(ErrorKind::invalid_argument, where + ": the user " + user->name + " is there twice");
        if (users.size() == max_users)
            return error(ErrorKind::invalid_argument, where + ": there are more than 64 users");
        users.push_back(std::move(*user));
    }
    if (users.empty()) return error(ErrorKind::invalid_argument, file.string() + ": holds no user");
    return users;
}

}  // namespace camrig::onvif
