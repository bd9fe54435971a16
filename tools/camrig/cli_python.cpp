#include "tools/camrig/cli_python.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <memory>
#include <system_error>

#include <CLI/CLI.hpp>
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tools/camrig/cli_commands.h"

namespace camrig::cli {

namespace fs = std::filesystem;

namespace {

constexpr const char* package_folder = "control/python";

std::vector<char*> argv_of(const std::vector<std::string>& words) {
    std::vector<char*> argv;
    for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    return argv;
}

/// Whether this Python has our package and what that needs. Finding a package does not import it: a fifth of the time.
Result<void> check_package(const std::string& python) {
    const std::vector<std::string> probe{python, "-c",
                                         "import importlib.util, sys; "
                                         "sys.exit(None in map(importlib.util.find_spec, ('camrig', 'numpy')))"};
    posix_spawn_file_actions_t quiet;
    posix_spawn_file_actions_init(&quiet);
    posix_spawn_file_actions_addopen(&quiet, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&quiet, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    pid_t child = -1;
    const int failed = ::posix_spawnp(&child, python.c_str(), &quiet, nullptr, argv_of(probe).data(), environ);
    posix_spawn_file_actions_destroy(&quiet);
    if (failed != 0) return error(ErrorKind::not_found, python + ": " + std::strerror(failed));
    int status = 0;
    while (::waitpid(child, &status, 0) < 0)
        if (errno != EINTR) return error(ErrorKind::internal, python + ": " + std::strerror(errno));
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
    return error(ErrorKind::unavailable, python + ": has not both");
}

}  // namespace

fs::path checkout_of(const fs::path& program) {
    std::error_code problem;
    for (fs::path folder = program.parent_path(); folder.has_relative_path(); folder = folder.parent_path())
        if (fs::exists(folder / package_folder / "pyproject.toml", problem)) return folder;
    return {};
}

std::vector<std::string> python_candidates(const fs::path& checkout) {
    if (const char* given = std::getenv("CAMRIG_PYTHON"); given != nullptr && *given != '\0') return {given};
    std::vector<std::string> candidates;
    if (!checkout.empty()) candidates.push_back(checkout / ".venv" / "bin" / "python");
    candidates.push_back("python3");
    return candidates;
}

Result<std::string> find_python(const std::vector<std::string>& candidates) {
    std::string tried;
    for (const std::string& python : candidates) {
        const auto good = check_package(python);
        if (good) return python;
        tried += good.error().message + "; ";
    }
    return error(ErrorKind::unavailable, "this command needs the Python packages camrig and numpy: " + tried +
                                             "pip install control/python of the sources, or set CAMRIG_PYTHON to a "
                                             "Python that has them");
}

int exec_python(const PythonCommand& command) {
    std::error_code problem;
    const fs::path checkout = checkout_of(fs::read_symlink("/proc/self/exe", problem));
    // Installed beside the program, the package is where Debian's Python looks only when the prefix is /usr.
    const fs::path installed =
        fs::read_symlink("/proc/self/exe", problem).parent_path() / "../lib/python3/dist-packages";
    const bool beside = fs::exists(installed / "camrig/__init__.py", problem);
    if (!checkout.empty() || beside) {
        const char* before = std::getenv("PYTHONPATH");
        const std::string path = checkout.empty() ? installed.lexically_normal() : checkout / package_folder;
        ::setenv("PYTHONPATH", before != nullptr && *before != '\0' ? (path + ":" + before).c_str() : path.c_str(), 1);
    }
    for (const auto& [name, value] : command.environment) ::setenv(name.c_str(), value.c_str(), 1);
    auto python = find_python(python_candidates(checkout));
    if (!python) {
        std::fprintf(stderr, "camrig: %s\n", python.error().message.c_str());
        return exit_failed;
    }
    std::vector<std::string> words{*python, "-m", command.module};
    words.insert(words.end(), command.arguments.begin(), command.arguments.end());
    ::execvp(words[0].c_str(), argv_of(words).data());
    std::fprintf(stderr, "camrig: %s: %s\n", words[0].c_str(), std::strerror(errno));
    return exit_failed;
}

void add_python_command(CLI::App& app, CliContext& context, const CliHooks& hooks, const std::string& name,
                        const std::string& module, const std::string& help) {
    CLI::App* command = app.add_subcommand(name, help);
    // All that follows the name is the module's, its --help too.
    command->fallthrough(false)->prefix_command()->set_help_flag();
    command->callback([module, command, &context, &hooks] {
        context.action = [module, command, &context, &hooks] {
            PythonCommand run{.module = module, .arguments = command->remaining(), .environment = {}};
            if (context.json) run.arguments.insert(run.arguments.begin(), "--json");
            run.environment.emplace_back("CAMRIG_CONTROL",
                                         context.control.empty() ? client::default_control() : context.control);
            if (!context.token_file.empty()) run.environment.emplace_back("CAMRIG_TOKEN_FILE", context.token_file);
            return hooks.python(run);
        };
    });
}

}  // namespace camrig::cli
