#include "rtsp_out/http/asking_page.h"

#include <algorithm>

namespace camrig::http {
namespace {

/// "http://name:port" of a URL; empty when it is none.
std::string_view origin_of(std::string_view url) {
    for (const std::string_view scheme : {"http://", "https://"}) {
        if (!url.starts_with(scheme)) continue;
        return url.substr(0, url.find_first_of("/?#", scheme.size()));
    }
    return {};
}

/// Browsers send Origin with some requests and Referer with most; nothing: neither of them.
std::optional<std::string_view> origin_of(const AskingPage& page) {
    if (page.origin) return page.origin;
    if (page.referer) return origin_of(*page.referer);
    return std::nullopt;
}

}  // namespace

Result<void> check_page_origin(std::string_view origin) {
    const std::size_t name = origin.find("://") + 3;
    const bool is_lower = std::ranges::none_of(origin, [](char c) { return c >= 'A' && c <= 'Z'; });
    if (!origin.empty() && origin_of(origin) == origin && name < origin.size() && is_lower &&
        origin.find_first_of(" @") == std::string_view::npos)
        return {};
    return error(
        ErrorKind::invalid_argument,
        "'" + std::string(origin.substr(0, 80)) +
            "' is no origin of a page; one is http://dashboard.example:3000, in lower case and without a path");
}

bool is_listed_page(const AskingPage& page, std::span<const std::string> origins) {
    const auto origin = origin_of(page);
    return origin && std::ranges::find(origins, *origin) != origins.end();
}

Result<void> check_page(const AskingPage& page) {
    const auto refuse = [](std::string_view why) {
        return error(ErrorKind::unauthorized, "a web page of another origin may not have pictures made (" +
                                                  std::string(why) +
                                                  "); to show them in a page of yours: camrig serve --embed ORIGIN");
    };
    if (page.sec_fetch_site && *page.sec_fetch_site != "same-origin" && *page.sec_fetch_site != "none")
        return refuse("Sec-Fetch-Site");
    const auto origin = origin_of(page);
    if (!origin) return {};
    const std::string_view place = origin->substr(std::min(origin->find("://"), origin->size()));
    if (page.host && place == "://" + std::string(*page.host)) return {};
    return refuse(page.origin ? "Origin" : "Referer");
}

}  // namespace camrig::http
