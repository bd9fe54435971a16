#include <map>

#include "tools/camrig/manual.h"

namespace camrig::cli {
namespace {

/// Inside of single quotes of any of the three shells.
std::string quoted(const std::string& text, const std::string& quote) {
    std::string out;
    for (const char c : text) out += c == '\'' ? quote : c == '\n' ? std::string(" ") : std::string(1, c);
    return "'" + out + "'";
}

std::string place(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) text += " " + word;
    return text;
}

void collect(const CommandNode& node, std::vector<const CommandNode*>& all) {
    all.push_back(&node);
    for (const CommandNode& command : node.commands) collect(command, all);
}

std::vector<const CommandNode*> all_of(const CommandNode& tree) {
    std::vector<const CommandNode*> all;
    collect(tree, all);
    return all;
}

/// Lines of a `case` that follow the words of the command line from command to command.
std::string steps(const std::vector<const CommandNode*>& all) {
    std::string places;
    for (const CommandNode* node : all)
        if (!node->words.empty()) places += (places.empty() ? "" : "|") + quoted(place(node->words), "");
    return "            " + places + ") at=\"$at $word\" ;;\n";
}

/// Options with a value, after which anything (a file, say) may stand.
std::string valued(const std::vector<const CommandNode*>& all) {
    std::map<std::string, bool> names;
    for (const CommandNode* node : all)
        for (const CommandOption& option : node->options)
            if (!option.value.empty())
                for (const std::string& name : option.names) names[name] = true;
    std::string text;
    for (const auto& [name, given] : names) text += (text.empty() ? "" : "|") + name;
    return text;
}

std::string bash(const CommandNode& tree) {
    const auto all = all_of(tree);
    std::string text =
        "# Completion of camrig for bash, made by: camrig completion bash\n_camrig() {\n"
        "    local at='' word words current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]}\n"
        "    COMPREPLY=()\n"
        "    for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
        "        [ \"$word\" = -- ] && return\n"
        "        case \"$at $word\" in\n" +
        steps(all) + "        esac\n    done\n    case \"$before\" in\n        " + valued(all) +
        ") return ;;\n    esac\n    case \"$at\" in\n";
    for (const CommandNode* node : all) {
        std::string words;
        for (const CommandNode& command : node->commands) words += command.words.back() + " ";
        for (const CommandNode* owner : {node, &tree})
            for (const CommandOption& option : owner->options)
                for (const std::string& name : option.names)
                    if (words.find(name + " ") == std::string::npos) words += name + " ";
        words.pop_back();
        text += "        '" + place(node->words) + "') words='" + words + "' ;;\n";
    }
    return text +
           "    esac\n    COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n}\n"
           "complete -o default -F _camrig camrig\n";
}

std::string zsh(const CommandNode& tree) {
    const auto all = all_of(tree);
    const auto entry = [](const std::string& name, const std::string& help) {
        std::string escaped;
        for (const char c : help) escaped += c == ':' ? std::string("\\:") : std::string(1, c);
        return "            " + quoted(name + ":" + escaped, "'\\''") + "\n";
    };
    std::string text =
        "#compdef camrig\n# Completion of camrig for zsh, made by: camrig completion zsh\n_camrig() {\n"
        "    local at='' word\n    local -a choices\n"
        "    for word in \"${words[@]:1:$((CURRENT-2))}\"; do\n"
        "        [[ $word == -- ]] && { _normal; return }\n"
        "        case \"$at $word\" in\n" +
        steps(all) + "        esac\n    done\n    case \"${words[CURRENT-1]}\" in\n        " + valued(all) +
        ") _files; return ;;\n    esac\n    case \"$at\" in\n";
    for (const CommandNode* node : all) {
        text += "        '" + place(node->words) + "') choices=(\n";
        for (const CommandNode& command : node->commands) text += entry(command.words.back(), command.help);
        for (const CommandOption& option : node->options)
            for (const std::string& name : option.names) text += entry(name, option.help);
        text += "            ) ;;\n";
    }
    return text +
           "    esac\n    _describe camrig choices || _files\n}\n"
           "if [ \"$funcstack[1]\" = _camrig ]; then _camrig \"$@\"; else compdef _camrig camrig; fi\n";
}

std::string fish(const CommandNode& tree) {
    const auto all = all_of(tree);
    std::string text =
        "# Completion of camrig for fish, made by: camrig completion fish\nfunction __camrig_at\n"
        "    set -l at ''\n    for word in (commandline -opc)[2..-1]\n        switch \"$at $word\"\n"
        "            case ";
    for (const CommandNode* node : all)
        if (!node->words.empty()) text += quoted(place(node->words), "") + " ";
    text += "\n                set at \"$at $word\"\n        end\n    end\n    test \"$at\" = \"$argv[1]\"\nend\n";
    for (const CommandNode* node : all) {
        const std::string here = "complete -c camrig -n \"__camrig_at '" + place(node->words) + "'\" ";
        for (const CommandNode& command : node->commands)
            text += here + "-f -a " + command.words.back() + " -d " + quoted(command.help, "\\'") + "\n";
        for (const CommandOption& option : node->options) {
            if (option.names.empty()) continue;
            text += here;
            for (const std::string& name : option.names)
                text += name.starts_with("--") ? "-l " + name.substr(2) + " " : "-s " + name.substr(1) + " ";
            text += (option.value.empty() ? "" : "-r ") + ("-d " + quoted(option.help, "\\'")) + "\n";
        }
    }
    return text;
}

}  // namespace

std::string completion_of(const CommandNode& tree, const std::string& shell) {
    return shell == "bash" ? bash(tree) : shell == "zsh" ? zsh(tree) : fish(tree);
}

}  // namespace camrig::cli
