#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace camrig::http {

/// What a browser says of the page that asks; empty optionals were not sent.
struct AskingPage {
    std::optional<std::string_view> host;  ///< ours, as it was asked for
    std::optional<std::string_view> origin;
    std::optional<std::string_view> referer;
    std::optional<std::string_view> sec_fetch_site;
};

/// An origin as browsers write it: "http://name:port" or "https://..", in lower case, without a path.
Result<void> check_page_origin(std::string_view origin);

/// Whether the page that asks is one of `origins`, which its user lets show our pictures (an empty Origin or Referer is
/// none).
bool is_listed_page(const AskingPage& page, std::span<const std::string> origins);

/// Keeps pages of other origins from making us work: an `<img>` of theirs with one of our addresses draws a picture,
/// though they cannot read it. `unauthorized` when the browser says that another origin asks; what says nothing is
/// a program. Sources: Fetch Metadata Request Headers (W3C), RFC 9110 section 10.1.3, RFC 6454.
Result<void> check_page(const AskingPage& page);

}  // namespace camrig::http
