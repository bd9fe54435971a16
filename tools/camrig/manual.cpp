#include "tools/camrig/manual.h"

#include <algorithm>
#include <cctype>

namespace camrig::cli {
namespace {

/// Text that roff takes as it stands: no escapes, hyphens that can be searched for, no requests at a line's start.
std::string roff(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '\\') {
            out += "\\e";
        } else if (c == '-') {
            out += "\\-";
        } else {
            if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n')) out += "\\&";
            out += c;
        }
    }
    return out;
}

std::string joined(const std::vector<std::string>& parts, const std::string& between) {
    std::string text;
    for (const std::string& part : parts) text += (text.empty() ? "" : between) + part;
    return text;
}

std::string upper(std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return text;
}

bool is_help(const CommandOption& option) {
    return std::ranges::find(option.names, "--help") != option.names.end();
}

std::string head(const std::string& page, const std::string& release, const std::string& summary) {
    return ".TH " + upper(roff(page)) + " 1 \"\" \"camrig " + release + "\" \"User Commands\"\n.SH NAME\n" +
           roff(page) + " \\- " + roff(summary) + "\n";
}

std::string synopsis(const CommandNode& node) {
    std::string line = ".B camrig" + (node.words.empty() ? "" : " " + roff(joined(node.words, " "))) + "\n";
    bool any = false;
    for (const CommandOption& option : node.options) any = any || (!option.names.empty() && !is_help(option));
    if (any) line += "[\\fIOPTION\\fR]...\n";
    if (!node.commands.empty()) line += "\\fICOMMAND\\fR ...\n";
    for (const CommandOption& option : node.options)
        if (option.names.empty())
            line += option.required ? "\\fI" + roff(option.value) + "\\fR\n" : "[\\fI" + roff(option.value) + "\\fR]\n";
    return line;
}

std::string option_list(const CommandNode& node) {
    std::string text;
    for (const CommandOption& option : node.options) {
        if (is_help(option)) continue;
        std::string names;
        for (const std::string& name : option.names)
            names += (names.empty() ? "" : ", ") + ("\\fB" + roff(name) + "\\fR");
        const std::string value = option.value.empty() ? "" : "\\fI" + roff(option.value) + "\\fR";
        text += ".TP\n" + names + (names.empty() || value.empty() ? "" : " ") + value + "\n" +
                roff(option.help.empty() ? "see docs" : option.help) + "\n";
    }
    return text;
}

void append_commands(std::string& text, const CommandNode& node) {
    for (const CommandNode& command : node.commands) {
        text += ".SS camrig " + roff(joined(command.words, " ")) + "\n" + roff(command.help) + "\n.PP\n" +
                synopsis(command) + option_list(command);
        append_commands(text, command);
    }
}

constexpr const char* surroundings = R"(.SH ENVIRONMENT
.TP
.B CAMRIG_CONTROL
The control socket, where \fB\-\-control\fR is not given.
.TP
.B CAMRIG_PYTHON
The Python that commands written in Python run with.
.TP
.B XDG_RUNTIME_DIR
Holds the control socket \fIcamrig.sock\fR by default.
.SH EXIT STATUS
0: done. 1: failed; one line on standard error says why. 2: wrong usage.
)";

}  // namespace

std::string manual_of_program(const CommandNode& tree, const std::string& release) {
    std::string page = head("camrig", release, "rig of virtual cameras that programs take for real ones") +
                       ".SH SYNOPSIS\n" + synopsis(tree) +
                       ".SH DESCRIPTION\nRenders one 3D world for many synchronised virtual cameras and serves each of "
                       "them as /dev/videoN, by RTSP and by HTTP.\n.SH COMMANDS\n";
    for (const CommandNode& command : tree.commands)
        page += ".TP\n\\fB" + roff(command.words.back()) + "\\fR\n" + roff(command.help) + "\n";
    page += ".SH OPTIONS\n" + option_list(tree) + surroundings + ".SH SEE ALSO\n";
    for (const CommandNode& command : tree.commands)
        page +=
            ".BR camrig\\-" + roff(command.words.back()) + " (1)" + (&command == &tree.commands.back() ? "\n" : ",\n");
    return page;
}

std::string manual_of_command(const CommandNode& tree, const CommandNode& command, const std::string& release) {
    std::string page = head("camrig-" + command.words.back(), release, command.help) + ".SH SYNOPSIS\n" +
                       synopsis(command) + ".SH DESCRIPTION\n" + roff(command.help) + ".\n";
    if (const std::string options = option_list(command); !options.empty()) page += ".SH OPTIONS\n" + options;
    if (!command.commands.empty()) {
        page += ".SH COMMANDS\n";
        append_commands(page, command);
    }
    return page + ".SH COMMON OPTIONS\n" + option_list(tree) + surroundings + ".SH SEE ALSO\n.BR camrig (1)\n";
}

}  // namespace camrig::cli
