#pragma once

#include <deque>
#include <mutex>
#include <set>
#include <string>
#include <string_view>

#include "control/onvif/soap.h"
#include "core/base/time.h"

namespace camrig::onvif {

/// Who may ask: the rig's token is the password, of any user, by WS-UsernameToken (digest or text) or by HTTP digest
/// (RFC 7616 with MD5, which is what clients of cameras know). Any thread.
class Authentication {
public:
    /// Messages older or newer than this are refused, and of the last max_digests none is taken twice. An answer to an
    /// HTTP challenge is good for as long, for any message to the same target.
    static constexpr TimeNs max_skew_ns = 300 * ns_per_s;
    static constexpr std::size_t max_digests = 16'384;

    /// An empty token: everybody may.
    explicit Authentication(std::string token);

    bool is_open() const { return token_.empty(); }
    /// `now_ns` is of CLOCK_REALTIME.
    bool is_good(const UsernameToken& token, TimeNs now_ns);
    /// Of HTTP: the value of WWW-Authenticate, and whether one of Authorization answers it for this request.
    std::string http_challenge(TimeNs now_ns) const;
    bool is_good_http(std::string_view method, std::string_view target, std::string_view authorization,
                      TimeNs now_ns) const;

private:
    /// False: it was there already.
    bool remember(const std::string& digest);
    std::string http_nonce(TimeNs now_s) const;

    const std::string token_;
    const std::string secret_;  ///< what our nonces are made from; nobody else knows it
    std::mutex mutex_;
    std::set<std::string, std::less<>> digests_;
    std::deque<std::string> digests_by_age_;
};

/// "2026-11-23T20:00:00Z", with or without a fraction of a second, which is of no account; nullopt: it is none.
std::optional<TimeNs> time_of_text(std::string_view text);
/// Whole seconds, in UTC.
std::string text_of_time(TimeNs utc_ns);

}  // namespace camrig::onvif
