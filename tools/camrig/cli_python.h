#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"

namespace camrig::cli {

/// A command of the command line that is a module of the Python package: `python -m MODULE ARGUMENTS`.
struct PythonCommand {
    std::string module;
    std::vector<std::string> arguments;
    /// Set for it beside what is there: $CAMRIG_CONTROL is the rig it talks to, $CAMRIG_TOKEN_FILE its token, if one
    /// was given.
    std::vector<std::pair<std::string, std::string>> environment;
};

/// The source checkout that `program` (a path) was built in, or nothing.
std::filesystem::path checkout_of(const std::filesystem::path& program);

/// Programs to look for the package in, best first: $CAMRIG_PYTHON and no other, else the checkout's .venv, else
/// python3.
std::vector<std::string> python_candidates(const std::filesystem::path& checkout);

/// The first of them that finds the package `camrig`; the error says how to install it.
Result<std::string> find_python(const std::vector<std::string>& candidates);

/// Becomes the command; returns an exit code, with a line on stderr, only when it cannot. In a checkout the package is
/// that of the checkout, installed or not.
int exec_python(const PythonCommand& command);

}  // namespace camrig::cli
