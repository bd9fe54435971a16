#include "control/client/endpoint.h"

#include <charconv>
#include <cstdlib>

#include <unistd.h>

namespace camrig::client {

Result<Endpoint> Endpoint::parse(std::string_view text) {
    Endpoint endpoint;
    const std::size_t colon = text.rfind(':');
    if (text.empty())
        return error(ErrorKind::invalid_argument, "--control: is empty; give a socket's path or HOST:PORT");
    if (colon == std::string_view::npos || text.find('/') != std::string_view::npos) {
        endpoint.unix_path = text;
        return endpoint;
    }
    const std::string_view digits = text.substr(colon + 1);
    const auto [end, failed] = std::from_chars(digits.data(), digits.data() + digits.size(), endpoint.port);
    endpoint.host = text.substr(0, colon);
    if (endpoint.host.size() > 2 && endpoint.host.front() == '[' && endpoint.host.back() == ']')
        endpoint.host = endpoint.host.substr(1, endpoint.host.size() - 2);
    if (failed != std::errc() || end != digits.data() + digits.size() || endpoint.port == 0 || endpoint.host.empty()) {
        return error(ErrorKind::invalid_argument, "--control: '" + std::string(text.substr(0, 120)) +
                                                      "' is neither HOST:PORT nor the path of a socket (with a /)");
    }
    return endpoint;
}

std::string Endpoint::to_string() const {
    return host.empty() ? unix_path : host + ":" + std::to_string(port);
}

std::string default_control() {
    if (const char* given = std::getenv("CAMRIG_CONTROL"); given && *given) return given;
    if (const char* folder = std::getenv("XDG_RUNTIME_DIR"); folder && *folder)
        return std::string(folder) + "/camrig.sock";
    return "/tmp/camrig-" + std::to_string(::getuid()) + ".sock";
}

}  // namespace camrig::client
