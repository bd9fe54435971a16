#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace camrig::cli {

/// One option or argument of a command, as its definition says.
struct CommandOption {
    std::vector<std::string> names;  ///< "-o", "--output"; empty: an argument by place
    std::string value;               ///< "NAME", "TEXT", ...; empty: a flag
    std::string help;
    bool required = false;
};

/// A command with what it takes. Plain data: manual pages and completions are made from it.
struct CommandNode {
    std::vector<std::string> words;  ///< "camera", "create"; empty: the program itself
    std::string help;
    std::vector<CommandOption> options;
    std::vector<CommandNode> commands;
};

CommandNode command_tree(const CLI::App& app);

}  // namespace camrig::cli
