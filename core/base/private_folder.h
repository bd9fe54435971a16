#pragma once

#include <string>

#include "core/base/result.h"

namespace camrig {

/// Makes a folder that nobody but this user can enter or change: mode 0700, no symbolic link. One that is there already
/// is taken only if it is such a folder. What is made in it afterwards can be neither prepared nor replaced by others,
/// also where the folder above (/tmp) is open to all.
///
/// unavailable: somebody else was there first, or it cannot be made; the message says what to remove. Any thread.
Result<void> make_private_folder(const std::string& path);

/// The same question of a folder that should be there; changes nothing.
Result<void> check_private_folder(const std::string& path);

/// Where this user's rigs and clients meet: $XDG_RUNTIME_DIR/camrig, else /tmp/camrig-UID. Need not be there.
std::string user_runtime_folder();

}  // namespace camrig
