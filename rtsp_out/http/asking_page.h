#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace camrig::http {

/// Header fields in which a browser names the page that makes a request; empty optionals were not sent.
struct AskingPage {
    std::optional<std::string_view> host;  ///< this server, as the request names it
    std::optional<std::string_view> origin;
    std::optional<std::string_view> referer;
    std::optional<std::string_view> sec_fetch_site;
};

/// Checks that this is an origin as browsers send it: "http://name:port" or "https://..", in lower case, without a
/// path. invalid_argument: it is not.
Result<void> check_page_origin(std::string_view origin);

/// Whether the page is of one of `origins`, those that the server's user allows to embed pictures
/// (HttpOptions::embedders). A request without Origin and Referer is of none.
bool is_listed_page(const AskingPage& page, std::span<const std::string> origins);

/// Refuses requests of other origins' pages, with `unauthorized`: an `<img>` on such a page cannot read a picture, but
/// would make the rig draw it. A request without these fields is of a program and passes.
/// Sources: Fetch Metadata Request Headers (W3C), RFC 9110 section 10.1.3, RFC 6454.
Result<void> check_page(const AskingPage& page);

}  // namespace camrig::http
