#pragma once

#include <optional>
#include <string_view>

#include "rtsp_out/http/http_options.h"

namespace camrig {

/// The small web page that stands in when HttpHooks::files gives none: all cameras, live. Made from page/ at build
/// time.
std::optional<StaticFile> builtin_page_file(std::string_view path);

}  // namespace camrig
