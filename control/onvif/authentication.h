#pragma once

#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "control/onvif/soap.h"
#include "control/onvif/users.h"
#include "core/base/time.h"

namespace camrig::onvif {

/// Who asks, by WS-UsernameToken (digest or text) or by HTTP digest (RFC 7616 with MD5, which is what clients of
/// cameras know; where OpenSSL forbids that, as by FIPS, with SHA-256). The users of the rig have passwords of their
/// own; the rig's token is a password of any name, and its holder an administrator. Any thread.
///
/// Passwords are kept as they are: the digest of WS-UsernameToken is made of the password itself, so that what HTTP
/// alone would need, a hash of name, realm and password, would not do, and is as good as the password to who steals it.
class Authentication {
public:
    /// Messages older or newer than this are refused, and so are answers to an HTTP challenge that is older; of the
    /// last max_digests of both none is taken twice.
    static constexpr TimeNs max_skew_ns = 300 * ns_per_s;
    static constexpr std::size_t max_digests = 16'384;

    /// Without a token and users everybody may everything.
    explicit Authentication(std::string token, std::vector<User> users = {});

    bool is_open() const { return token_.empty() && users_.empty(); }
    const std::vector<User>& users() const { return users_; }
    /// nullopt: nobody who may. `now_ns` is of CLOCK_REALTIME.
    std::optional<Role> role_of(const UsernameToken& token, TimeNs now_ns);
    /// Of HTTP: the value of WWW-Authenticate, and who answers it for this request by Authorization.
    std::string http_challenge(TimeNs now_ns, bool is_stale = false) const;
    struct HttpCaller {
        std::optional<Role> role;
        bool is_stale = false;  ///< the password is right, but the nonce too old or the answer seen: come again at once
    };
    HttpCaller http_caller(std::string_view method, std::string_view target, std::string_view authorization,
                           TimeNs now_ns);

private:
    /// False: it was there already.
    bool remember(const std::string& digest);
    std::string http_nonce(TimeNs made_ns) const;
    /// The role of the user of that name, or of who holds the token, if `is_right` says so of the password.
    template <typename IsRight>
    std::optional<Role> find(std::string_view name, IsRight is_right) const;

    const std::string token_;
    const std::vector<User> users_;
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
