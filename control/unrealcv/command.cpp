#include "control/unrealcv/command.h"

#include <algorithm>

#include "control/unrealcv/units.h"

namespace camrig::unrealcv {
namespace {

bool is_value(std::string_view placeholder, std::string_view text) {
    if (placeholder == "[uint]") return integer_of(text).has_value();
    if (placeholder == "[float]") return number_of(text).has_value();
    return true;
}

}  // namespace

bool matches(std::string_view pattern, std::string_view line, std::vector<std::string_view>& arguments) {
    arguments.clear();
    while (!pattern.empty()) {
        const std::size_t open = pattern.find('[');
        const std::string_view literal = pattern.substr(0, open);
        if (!line.starts_with(literal)) return false;
        line.remove_prefix(literal.size());
        if (open == std::string_view::npos) break;
        const std::size_t end = pattern.find(']') + 1;
        const std::string_view placeholder = pattern.substr(open, end - open);
        pattern.remove_prefix(end);
        const bool is_last = placeholder == "[rest]";
        // What follows within a path ends at its next part.
        const std::string_view ends = pattern.starts_with('/') ? "/ " : " ";
        const std::string_view value = is_last ? line : line.substr(0, line.find_first_of(ends));
        if (!is_value(placeholder, value)) return false;
        arguments.push_back(value);
        line.remove_prefix(value.size());
    }
    return line.empty();
}

std::span<const Command> commands() {
    static const std::vector<Command> all = [] {
        std::vector<Command> made;
        for (const auto family :
             {plugin_commands(), camera_commands(), picture_commands(), object_commands(), action_commands()})
            made.insert(made.end(), family.begin(), family.end());
        return made;
    }();
    return all;
}

}  // namespace camrig::unrealcv
