#pragma once

#include <optional>
#include <string_view>

namespace camrig::control {

/// A file of the web page. Its text is part of the program.
struct PageFile {
    std::string_view content_type;
    std::string_view text;
};

/// The file that a path of the HTTP server names; "/" is index.html. Pure, any thread.
std::optional<PageFile> page_file(std::string_view path);

}  // namespace camrig::control
