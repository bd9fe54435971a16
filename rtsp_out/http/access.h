#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace camrig::http {

/// The header fields that decide whether a request is allowed; empty optionals were not sent.
struct RequestOrigin {
    std::string_view method;
    std::optional<std::string_view> host;
    std::optional<std::string_view> origin;
    std::optional<std::string_view> sec_fetch_site;
};

/// The token a request carries: `Authorization: Bearer T`, else the query's `token`, else the cookie `camrig_token`
/// (set when a page was opened with ?token=, so that its pictures and scripts need none). Empty: none.
std::string_view token_of(std::string_view authorization, const std::string* query_token, std::string_view cookie);

/// "localhost", "127.0.0.1", "[::1]", "x.localhost": with or without a port.
bool is_loopback_host(std::string_view host_and_port);

/// Refuses requests that other web sites make through a user's browser (cross-site request forgery, DNS rebinding).
/// Programs that are no browsers pass: they send none of these fields but Host. `unauthorized`: refused.
///
/// Host: must name this machine's loopback or the configured host, or else a page whose DNS name was re-bound to
/// 127.0.0.1 would be "same origin" with us. With a token set any Host will do: such a page does not know it. Anything
/// but GET, HEAD and OPTIONS: Origin must be the Host that was asked, Sec-Fetch-Site same-origin or none. No CORS
/// header is ever sent, so foreign pages cannot read what they GET.
Result<void> check_origin(const RequestOrigin& request, std::string_view configured_host, bool token_set);

}  // namespace camrig::http
