#pragma once

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "tools/camrig/cli_python.h"
#include "tools/camrig/serve.h"

namespace camrig::cli {

/// What the command line works on; tests give their own.
struct CliHooks {
    std::function<int(const ServeOptions&)> serve;
    std::ostream& out;
    std::ostream& err;
    /// `camrig exec`: becomes the command, with the devices of the rig whose control socket this is.
    std::function<int(const std::vector<std::string>& command, const std::string& control)> exec = {};
    /// Commands that are written in Python: becomes Python.
    std::function<int(const PythonCommand&)> python = {};
    /// `camrig view`: becomes the window's program with these arguments.
    std::function<int(const std::vector<std::string>& arguments)> view = {};
};

/// Runs one command; `arguments` without the program's name. Returns the exit code: 0, 1 (one line on err says why) or
/// 2 (wrong usage).
int run_cli(std::vector<std::string> arguments, const CliHooks& hooks);

}  // namespace camrig::cli
