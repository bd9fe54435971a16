#include "tools/camrig/command_tree.h"

#include <CLI/CLI.hpp>

namespace camrig::cli {
namespace {

CommandOption option_of(const CLI::Option& option) {
    CommandOption made;
    for (const std::string& name : option.get_snames()) made.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) made.names.push_back("--" + name);
    if (made.names.empty()) {
        made.value = option.get_name(true);
    } else if (option.get_items_expected_max() > 0) {
        // A type that lists its values has them in braces; the help says them too.
        const std::string type = option.get_type_name();
        made.value = type.empty() || type.find_first_of("{:") != std::string::npos ? "VALUE" : type;
    }
    made.help = option.get_description();
    made.required = option.get_required();
    return made;
}

CommandNode node_of(const CLI::App& app, std::vector<std::string> words) {
    CommandNode node;
    node.words = std::move(words);
    node.help = app.get_description();
    for (const CLI::Option* option : app.get_options([](const CLI::Option*) { return true; }))
        node.options.push_back(option_of(*option));
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
        std::vector<std::string> longer = node.words;
        longer.push_back(command->get_name());
        node.commands.push_back(node_of(*command, std::move(longer)));
    }
    return node;
}

}  // namespace

CommandNode command_tree(const CLI::App& app) {
    return node_of(app, {});
}

}  // namespace camrig::cli
