#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/base/named.h"
#include "core/base/result.h"

namespace camrig::onvif {

/// The levels of users of ONVIF Core, in the order of what they may; least_role() tells what that is.
enum class Role : std::uint8_t { user, op, administrator };
inline std::span<const Named<Role>> names_of(std::type_identity<Role>) {
    static constexpr Named<Role> names[] = {
        {Role::user, "user"}, {Role::op, "operator"}, {Role::administrator, "administrator"}};
    return names;
}

struct User {
    std::string name;
    Role role = Role::user;
    std::string password;
};
inline constexpr std::size_t max_users = 64;

/// Lines "NAME ROLE PASSWORD"; empty ones and those that begin with '#' are skipped. A name is 1 to 64 printable
/// characters without blanks, a password 8 to 128, which may have blanks within. invalid_argument: anything else,
/// with the line's number; a name that is there twice; or others than the file's owner may read or write it.
Result<std::vector<User>> read_users_file(const std::filesystem::path& file);

}  // namespace camrig::onvif
