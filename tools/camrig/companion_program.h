#pragma once

#include <string>
#include <vector>

/// Programs that come with camrig and are apart from it for the libraries that they need.
namespace camrig::cli {

struct Companion {
    std::string command;       ///< of camrig: "view"
    std::string build_folder;  ///< beside this program's in the build tree
    std::string variable;      ///< of the environment, that names the program; "": none does
    std::string missing;       ///< what to say where it is not there
};
extern const Companion view_program, bake_program;

/// Becomes camrig-COMMAND: what the variable names, else what lies beside this program, in ../lib/camrig, or in the
/// build tree of this program. Returns only on failure, after one line on stderr.
int exec_companion(const Companion& companion, const std::vector<std::string>& arguments);

}  // namespace camrig::cli
