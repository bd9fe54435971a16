#include "tools/camrig/companion_program.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>

#include <unistd.h>

#include "tools/camrig/cli_context.h"

namespace camrig::cli {

namespace fs = std::filesystem;

const Companion view_program{.command = "view",
                             .build_folder = "view",
                             .variable = "CAMRIG_VIEW",
                             .missing =
                                 "this camrig was built without its window (Debian: libglfw3-dev "
                                 "libimgui-dev); the web page of the rig can do much of the same"};
const Companion bake_program{.command = "bake",
                             .build_folder = "bake",
                             .variable = "",
                             .missing = "this camrig was built without Embree (Debian: libembree-dev)"};

namespace {

std::string find_companion(const Companion& companion) {
    if (const char* given = companion.variable.empty() ? nullptr : std::getenv(companion.variable.c_str());
        given != nullptr && *given != '\0')
        return given;
    const std::string name = "camrig-" + companion.command;
    std::error_code problem;
    const fs::path folder = fs::read_symlink("/proc/self/exe", problem).parent_path();
    for (const fs::path& place :
         {folder / name, folder / ".." / "lib" / "camrig" / name, folder / ".." / companion.build_folder / name})
        if (fs::exists(place, problem)) return fs::weakly_canonical(place, problem).string();
    return {};
}

}  // namespace

int exec_companion(const Companion& companion, const std::vector<std::string>& arguments) {
    const std::string program = find_companion(companion);
    const char* const command = companion.command.c_str();
    if (program.empty()) {
        std::fprintf(stderr, "camrig: %s: %s\n", command, companion.missing.c_str());
        return exit_failed;
    }
    std::vector<std::string> given{"camrig-" + companion.command};
    given.insert(given.end(), arguments.begin(), arguments.end());
    std::vector<char*> words;
    for (std::string& word : given) words.push_back(word.data());
    words.push_back(nullptr);
    ::execv(program.c_str(), words.data());
    std::fprintf(stderr, "camrig: %s: %s: %s\n", command, program.c_str(), std::strerror(errno));
    return exit_failed;
}

}  // namespace camrig::cli
