#include "rtsp_out/http/access.h"

#include <algorithm>

namespace camrig::http {
namespace {

constexpr std::string_view cookie_name = "camrig_token=";

char lower(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool equals_ignoring_case(std::string_view left, std::string_view right) {
    return std::ranges::equal(left, right, {}, lower, lower);
}

std::string_view without_port(std::string_view host) {
    if (host.starts_with('[')) return host.substr(0, std::min(host.find(']'), host.size() - 1) + 1);
    return host.substr(0, host.find(':'));
}

std::string_view without_brackets(std::string_view host) {
    if (host.size() >= 2 && host.front() == '[' && host.back() == ']') return host.substr(1, host.size() - 2);
    return host;
}

bool is_four_numbers(std::string_view text) {
    return !text.empty() && std::ranges::count(text, '.') == 3 &&
           text.find_first_not_of("0123456789.") == std::string_view::npos;
}

}  // namespace

std::string_view token_of(std::string_view authorization, const std::string* query_token, std::string_view cookie) {
    constexpr std::string_view scheme = "bearer ";
    if (authorization.size() > scheme.size() && equals_ignoring_case(authorization.substr(0, scheme.size()), scheme)) {
        authorization.remove_prefix(
            std::min(authorization.find_first_not_of(' ', scheme.size()), authorization.size()));
        return authorization;
    }
    if (query_token) return *query_token;
    while (!cookie.empty()) {
        const std::size_t end = std::min(cookie.find(';'), cookie.size());
        std::string_view one = cookie.substr(0, end);
        cookie.remove_prefix(std::min(end + 1, cookie.size()));
        one.remove_prefix(std::min(one.find_first_not_of(' '), one.size()));
        if (one.starts_with(cookie_name)) return one.substr(cookie_name.size());
    }
    return {};
}

bool is_loopback_host(std::string_view host_and_port) {
    std::string name(without_brackets(without_port(host_and_port)));
    std::ranges::transform(name, name.begin(), lower);
    if (name == "localhost" || name.ends_with(".localhost") || name == "::1") return true;
    return name.starts_with("127.") && is_four_numbers(name);
}

Result<void> check_origin(const RequestOrigin& request, std::string_view configured_host, bool token_set) {
    if (request.host && !token_set && !is_loopback_host(*request.host) &&
        !equals_ignoring_case(without_brackets(without_port(*request.host)), without_brackets(configured_host))) {
        return error(ErrorKind::unauthorized, "Host '" + std::string(request.host->substr(0, 80)) +
                                                  "' is not this server's; use localhost, 127.0.0.1 or the address "
                                                  "given by --host");
    }
    if (request.method == "GET" || request.method == "HEAD" || request.method == "OPTIONS") return {};
    const auto refuse = [](std::string_view why) {
        return error(ErrorKind::unauthorized,
                     "a web page of another origin may not control the rig (" + std::string(why) + ")");
    };
    if (request.sec_fetch_site && *request.sec_fetch_site != "same-origin" && *request.sec_fetch_site != "none")
        return refuse("Sec-Fetch-Site");
    if (!request.origin) return {};
    std::string_view origin = *request.origin;
    for (const std::string_view scheme : {"http://", "https://"}) {
        if (!origin.starts_with(scheme)) continue;
        origin.remove_prefix(scheme.size());
        if (request.host && equals_ignoring_case(origin, *request.host)) return {};
    }
    return refuse("Origin");
}

}  // namespace camrig::http
