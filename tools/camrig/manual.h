#pragma once

#include <string>

#include "tools/camrig/command_tree.h"

namespace camrig::cli {

/// The manual page of the whole program (`tree`, section 1) in roff.
std::string manual_of_program(const CommandNode& tree, const std::string& release);
/// The page of one command of `tree` with all below it: camrig-camera(1).
std::string manual_of_command(const CommandNode& tree, const CommandNode& command, const std::string& release);

/// What a shell loads to complete `camrig ...`; shell: "bash", "zsh" or "fish".
std::string completion_of(const CommandNode& tree, const std::string& shell);

}  // namespace camrig::cli
